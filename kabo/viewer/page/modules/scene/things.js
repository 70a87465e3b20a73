// The things of a scene on the stage: every link, body and region with its shapes in layers.
import {
  Box3, BufferAttribute, Color, DoubleSide, EdgesGeometry, Group, LineBasicMaterial, LineSegments, Matrix4, Mesh,
  MeshLambertMaterial,
} from "three";
import { features, frame, viewCone } from "kabo/layers.js";
import { geometryOf } from "kabo/surfaces.js";

const ROBOTS = [0xd98a3d, 0x5b8fd0, 0x6fae6a, 0xb578c0, 0x4fb0ae, 0xc9635f];
const MOVABLE = [0x3f8f5b, 0xc8563c, 0x8a6bbf, 0xd2a12b, 0x3d86b5, 0xb65a8c, 0x7c8f34, 0x9b6a46];
const FIXED = 0xb4b8be;
const REGION = 0x4d8fd6;
const HULL = 0x7a5cc0;
const HUES = [0, 0.06, -0.04, 0.1, 0.03, 0.14]; // by which the colours of a thing's parts differ, of the circle
const FADED = 0.12; // opacity of what is not looked at
const THROUGH = 0.6; // opacity of what lets its inside be seen
const SOLID = ["original", "enclosing", "hull"];

/** All things of a scene by name: bodies, regions and `robot.link`. */
export function thingsOf(view, arrays, size) {
  const things = new Map();
  const add = (kind, name, robot, colour, described) => {
    things.set(name, new Thing({ kind, name, robot, colour, described, view, arrays, size }));
  };
  view.robots.forEach((robot, index) => robot.links.forEach((link) => {
    add("link", `${robot.name}.${link.name}`, robot, ROBOTS[index % ROBOTS.length], link);
  }));
  let moved = 0;
  for (const body of view.bodies) {
    const usual = body.movable ? MOVABLE[moved++ % MOVABLE.length] : FIXED;
    add("body", body.name, null, body.colour ?? usual, body); // that of its name, if it is called by one
  }
  view.regions.forEach((region) => add("region", region.name, null, REGION, region));
  return things;
}

export class Thing {
  constructor(given) {
    Object.assign(this, given);
    this.robotName = this.robot?.name ?? null;
    this.group = new Group();
    this.group.matrixAutoUpdate = false;
    this.layers = new Map();
    this.marked = null;
    this.isFaded = false;
    this.isThrough = false;
    this.setVisible(this.kind === "region" ? "regions" : "original", true);
  }

  /** Shows or hides a layer, which is made when it is first shown. */
  setVisible(layer, visible) {
    if (visible && !this.layers.has(layer)) {
      const made = this.make(layer);
      if (made) {
        this.group.add(made);
      }
      this.layers.set(layer, made);
    }
    const shown = this.layers.get(layer);
    if (shown) {
      shown.visible = visible;
      this.colourAll();
    }
  }

  make(layer) {
    if (layer === "regions") {
      return this.kind === "region" ? this.region() : null;
    }
    if (layer === "frames") {
      return this.kind === "region" ? null : frame(this.isTool() ? 2 * this.size : this.size);
    }
    if (layer === "features") {
      const own = this.kind === "link" ? (this.isTool() ? this.robot.tool.features : []) : this.described.features ?? [];
      return own.length ? features(own, this.size) : null;
    }
    if (layer === "sensors") {
      return this.sensors();
    }
    const shapes = this.kind === "region" ? [] : this.described.shapes[layer] ?? [];
    return shapes.length ? this.solid(shapes, layer) : null;
  }

  isTool() {
    return this.robot?.tool?.frame === this.described.name;
  }

  sensors() {
    const own = (this.robot?.sensors ?? []).filter((each) => each.link === this.described.name);
    if (!own.length) {
      return null;
    }
    const made = new Group();
    made.add(...own.map(viewCone));
    return made;
  }

  geometry(shapes) {
    return geometryOf(shapes.map((each) => this.view.meshes[each.mesh]), this.arrays);
  }

  solid(shapes, layer) {
    const geometry = this.geometry(shapes);
    const own = layer === "hull" ? HULL : this.colour;
    const material = new MeshLambertMaterial({ color: new Color(own), side: DoubleSide });
    if (layer === "enclosing") {
      tintParts(geometry, shapes.map((each) => this.view.meshes[each.mesh]), this.arrays, this.colour);
      Object.assign(material, { vertexColors: true, color: new Color(0xffffff) });
    }
    if (layer !== "original") { // in front of a mesh that it coincides with
      Object.assign(material, { polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -4 });
    }
    const made = new Mesh(geometry, material);
    made.userData = { name: this.name, own: material.color.getHex(), opacity: layer === "original" ? 1 : 0.45 };
    return made;
  }

  region() {
    const geometry = this.geometry(this.described.shapes.original);
    const edges = new LineSegments(new EdgesGeometry(geometry, 20), new LineBasicMaterial({ color: this.colour }));
    const faces = new Mesh(geometry, new MeshLambertMaterial({ color: this.colour, side: DoubleSide,
      polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -8 })); // in front of a floor in its plane
    edges.userData = { own: this.colour, opacity: 1 };
    faces.userData = { own: this.colour, opacity: 0.08 };
    const made = new Group();
    made.add(faces, edges);
    return made;
  }

  /** Gives the thing another colour; null: its own. */
  highlight(colour) {
    this.marked = colour;
    this.colourAll();
  }

  /** Whether the thing steps back behind others, or lets what is inside be seen. */
  fade(faded, through = false) {
    this.isFaded = faded;
    this.isThrough = through;
    this.colourAll();
  }

  colourAll() {
    const covered = SOLID.slice(1).some((each) => this.layers.get(each)?.visible);
    this.group.traverse((object) => {
      const { own, opacity } = object.userData;
      if (own === undefined) {
        return;
      }
      const { material } = object;
      material.color.set(this.marked ?? own);
      material.emissive?.set(this.marked ?? 0).multiplyScalar(0.3);
      const alone = opacity < 1 && covered && !this.layers.get("original")?.visible && this.kind !== "region";
      const strong = this.marked !== null && opacity < 1 ? 2.5 : 1;
      const wanted = (alone ? 1 : opacity * strong) * (this.isFaded ? FADED : 1) * (this.isThrough ? THROUGH : 1);
      const transparent = wanted < 1;
      if (material.transparent !== transparent) {
        material.needsUpdate = true;
      }
      Object.assign(material, { opacity: Math.min(1, wanted), transparent, depthWrite: !transparent });
    });
  }

  /** The meshes that can be clicked. */
  solids() {
    return SOLID.map((each) => this.layers.get(each)).filter((each) => each?.visible);
  }

  /** The bounding box of its shapes in the world. */
  box() {
    const box = new Box3();
    const shape = this.layers.get(this.kind === "region" ? "regions" : "original");
    shape?.traverse((each) => {
      if (each.geometry?.boundingBox) {
        box.union(each.geometry.boundingBox);
      }
    });
    return box.isEmpty() ? box : box.applyMatrix4(new Matrix4().copy(this.group.matrix));
  }
}

/** Gives each part of an enclosure a colour of its own, so that one sees where it ends. */
function tintParts(geometry, meshes, arrays, own) {
  const colours = new Float32Array(geometry.getAttribute("position").array.length);
  let at = 0;
  meshes.forEach((mesh, index) => {
    const colour = new Color(own).offsetHSL(HUES[index % HUES.length], 0, 0.09 * (index % 3) - 0.05).toArray();
    for (let corner = 0; corner < arrays[mesh.faces.array].length; corner += 1, at += 3) {
      colours.set(colour, at);
    }
  });
  geometry.setAttribute("color", new BufferAttribute(colours, 3));
}
