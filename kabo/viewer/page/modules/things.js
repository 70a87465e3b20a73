// The things of a scene on the stage: every link, body and region with its shapes in layers.
import {
  Box3, Color, DoubleSide, EdgesGeometry, Group, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial,
} from "three";
import { geometryOf } from "kabo/surfaces.js";

const ROBOTS = [0xd98a3d, 0x5b8fd0, 0x6fae6a, 0xb578c0, 0x4fb0ae, 0xc9635f];
const MOVABLE = [0x3f8f5b, 0xc8563c, 0x8a6bbf, 0xd2a12b, 0x3d86b5, 0xb65a8c, 0x7c8f34, 0x9b6a46];
const FIXED = 0xa9adb3;
const REGION = 0x4d8fd6;

/** All things of a scene by name: bodies, regions and `robot.link`. */
export function thingsOf(view, arrays) {
  const things = new Map();
  const add = (thing) => things.set(thing.name, thing);
  view.robots.forEach((robot, index) => robot.links.forEach((link) => {
    add(new Thing("link", `${robot.name}.${link.name}`, robot.name, ROBOTS[index % ROBOTS.length], link, view, arrays));
  }));
  let moved = 0;
  for (const body of view.bodies) {
    const colour = body.movable ? MOVABLE[moved++ % MOVABLE.length] : FIXED;
    add(new Thing("body", body.name, null, colour, body, view, arrays));
  }
  view.regions.forEach((region) => add(new Thing("region", region.name, null, REGION, region, view, arrays)));
  return things;
}

export class Thing {
  constructor(kind, name, robot, colour, described, view, arrays) {
    Object.assign(this, { kind, name, robot, colour, described, view, arrays });
    this.group = new Group();
    this.group.matrixAutoUpdate = false;
    this.layers = new Map();
    this.setVisible(kind === "region" ? "regions" : "original", true);
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
    }
  }

  make(layer) {
    if (layer === "regions") {
      return this.kind === "region" ? this.region() : null;
    }
    const shapes = this.kind === "region" ? [] : this.described.shapes[layer] ?? [];
    return shapes.length ? this.solid(shapes, layer) : null;
  }

  geometry(shapes) {
    return geometryOf(shapes.map((each) => this.view.meshes[each.mesh]), this.arrays);
  }

  solid(shapes, layer) {
    const material = new MeshLambertMaterial({ color: new Color(this.colour), side: DoubleSide });
    const made = new Mesh(this.geometry(shapes), material);
    made.userData.name = this.name;
    made.name = layer;
    return made;
  }

  region() {
    const geometry = this.geometry(this.described.shapes.original);
    const edges = new LineSegments(new EdgesGeometry(geometry, 20), new LineBasicMaterial({ color: this.colour }));
    const faces = new Mesh(geometry, new MeshLambertMaterial({
      color: this.colour, transparent: true, opacity: 0.1, depthWrite: false, side: DoubleSide,
    }));
    const made = new Group();
    made.add(edges, faces);
    return made;
  }

  /** Gives the thing another colour; null: its own. */
  highlight(colour) {
    const change = (object) => {
      object.material?.color.set(colour ?? this.colour);
      object.material?.emissive?.set(colour ?? 0).multiplyScalar(0.25);
    };
    this.group.traverse(change);
  }

  /** The meshes that can be clicked. */
  solids() {
    const shown = this.layers.get("original");
    return shown?.visible ? [shown] : [];
  }

  /** The bounding box in the world. */
  box() {
    return new Box3().setFromObject(this.group);
  }
}
