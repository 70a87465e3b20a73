// The stage: the scene in three dimensions. It shows states that it is given; it never interpolates them.
import {
  AmbientLight, Box3, Color, DirectionalLight, HemisphereLight, OrbitControls, PerspectiveCamera, Raycaster,
  Scene, Vector2, Vector3, WebGLRenderer,
} from "three";
import { distanceTo, freeDirection, viewedBox } from "kabo/camera.js";
import { drag } from "kabo/dragging.js";
import { scenePoses, valuesOf } from "kabo/kinematics.js";
import { Labels } from "kabo/labels.js";
import { grid } from "kabo/layers.js";
import { thingsOf } from "kabo/things.js";

const DENSITIES = [2, 1, 0.5]; // pixels drawn for a pixel of the page: at rest, and while a slow machine moves things
const [SLOW, REST] = [45, 300]; // milliseconds: a frame that takes long, and after which time the stage is at rest
const PICTURE = 800; // width of a picture in which names are as large as on the screen [pixels]
const FRAME = 0.06; // length of the axes of frames [m]
const HIGHLIGHTS = { bad: 0xd0342c, good: 0x2c9a4b, chosen: 0x2f7de1, warn: 0xd08a00 };

export class Stage {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {object} view the SceneView
   * @param {TypedArray[]} arrays
   */
  constructor(canvas, view, arrays) {
    this.canvas = canvas;
    this.view = view;
    this.renderer = new WebGLRenderer({ canvas, antialias: false }); // edges are smoothed by more pixels
    this.level = 1; // of DENSITIES: of the next frame
    this.pace = 0; // the level while things move
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(40, 1, 0.01, 200);
    this.camera.up.set(0, 0, 1);
    this.addLights();
    this.things = thingsOf(view, arrays, FRAME);
    this.scene.add(...[...this.things.values()].map((thing) => thing.group));
    this.overlays = new Map();
    this.pickers = [];
    this.framed = [];
    this.stated = [];
    this.labels = new Labels(canvas.parentElement, this.things);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.visible = new Map([["original", true], ["regions", true], ["labels", true], ["grid", true]]);
    this.setState(view.start);
    this.setVisible("grid", true);
    this.look([]);
    this.listen();
    drag(this);
  }

  addLights() {
    const sun = new DirectionalLight(0xffffff, 1.9);
    sun.position.set(0.5, 0.9, 1.0);
    this.camera.add(sun);
    this.scene.add(this.camera, new HemisphereLight(0xffffff, 0x8a8f98, 1.3), new AmbientLight(0xffffff, 0.35));
  }

  // ------------------------------------------------------------------------------------------------------- states
  /** Shows a state; robots and objects that it does not name stay where they are. */
  setState(state) {
    const before = this.state ?? this.view.start;
    const robots = { ...before.robots };
    for (const [name, values] of Object.entries(state.robots ?? {})) {
      robots[name] = { ...robots[name], ...valuesOf(values) };
    }
    this.state = { robots, objects: { ...before.objects, ...state.objects } };
    this.poses = scenePoses(this.view, this.state);
    for (const [name, thing] of this.things) {
      const pose = this.poses.get(name);
      if (pose) {
        thing.group.matrix.set(...pose);
        thing.group.matrixWorldNeedsUpdate = true;
      }
    }
    this.stated.forEach((f) => f(this.state));
    this.draw();
  }

  /** Calls `f` with every state that is shown. */
  onState(f) {
    this.stated.push(f);
  }

  /** The state that is shown. */
  stateNow() {
    return this.state;
  }

  /** The pose of `world`, a body, a region or a `robot.link`: 16 numbers, row by row; null if there is none. */
  poseOf(name) {
    return this.poses.get(name) ?? null;
  }

  // ------------------------------------------------------------------------------------------------- what is seen
  /**
   * Highlights some things (a robot's name means all its links): bad, good, warn, chosen; null: no longer, and with no
   * names nothing is any longer.
   */
  highlight(names, cssClass) {
    const colour = cssClass === null ? null : HIGHLIGHTS[cssClass] ?? HIGHLIGHTS.chosen;
    for (const thing of names.length || cssClass !== null ? this.named(names) : this.things.values()) {
      thing.highlight(colour);
    }
    this.draw();
  }

  /** The things of these names; the name of a robot means its links. */
  named(names) {
    const all = [...this.things.values()];
    return names.flatMap((name) => all.filter((each) => each.name === name || each.robotName === name));
  }

  /** Lets all but some things fade; null: nothing fades. With `through`, one sees where these overlap. */
  focus(names, through = false) {
    const seen = names === null ? null : new Set(this.named(names));
    for (const thing of this.things.values()) {
      thing.fade(seen !== null && !seen.has(thing), through && seen.has(thing));
    }
    this.draw();
  }

  /** Shows an object of three.js in the world under an identifier, in place of the one before; null: none. */
  overlay(id, object) {
    const old = this.overlays.get(id);
    if (old) {
      this.scene.remove(old);
      this.overlays.delete(id);
    }
    if (object) {
      this.overlays.set(id, object);
      this.scene.add(object);
    }
    this.draw();
  }

  /** Turns the camera's middle to some things, and goes as near as shows them; no names: all that is solid. */
  look(names) {
    this.fit();
    const box = names.length ? boxOf(this.named(names)) : boxed(viewedBox(this.wanted(), this.regions(), this.solids()));
    const middle = box.getCenter(new Vector3());
    const radius = Math.max(0.05, box.getSize(new Vector3()).length() / 2);
    const towards = this.looked ? this.camera.position.clone().sub(this.controls.target).normalize()
      : freeDirection(this.wanted(), this.solids(), box, this.camera);
    const distance = distanceTo(box, towards, this.camera) * (names.length ? 1.5 : 1);
    this.camera.position.copy(middle).addScaledVector(towards, distance);
    this.camera.near = distance / 200;
    this.camera.far = (distance + radius) * 50;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(middle);
    this.controls.update();
    this.looked = true;
    this.draw();
  }

  /** Shows or hides a layer: original, enclosing, hull, regions, frames, features, sensors, labels or grid. */
  setVisible(layer, visible) {
    this.visible.set(layer, visible);
    if (layer === "labels") {
      this.labels.setVisible(visible);
    } else if (layer === "grid") {
      this.overlay("grid", visible ? grid(this.solidBox(), this.colour("--grid")) : null);
    }
    for (const thing of this.things.values()) {
      thing.setVisible(layer, visible);
    }
    this.draw();
  }

  /** Asks for a frame; as often as it is called, one is drawn. */
  draw() {
    this.asked ??= requestAnimationFrame(() => {
      this.keepPace();
      this.drawNow();
    });
  }

  /** Frames that follow each other slowly get fewer pixels; the stage at rest has all of them again. */
  keepPace() {
    const now = performance.now();
    const between = now - (this.drawnAt ?? -Infinity);
    this.drawnAt = now;
    if (between > SLOW && between < REST && this.level === this.pace) {
      this.pace = Math.min(this.pace + 1, DENSITIES.length - 1);
    }
    this.level = between < REST ? this.pace : Math.max(this.pace, 1);
    clearTimeout(this.resting);
    this.resting = setTimeout(() => { this.level = 0; this.drawNow(); }, REST);
  }

  /** Draws at once: for a picture of the canvas, which is empty after the frame. */
  drawNow() {
    cancelAnimationFrame(this.asked);
    this.asked = undefined;
    this.fit();
    this.scene.background = this.colour("--stage");
    this.renderer.render(this.scene, this.camera);
    this.labels.place(this.camera, this.canvas);
    this.framed.forEach((f) => f());
  }

  /** A picture of what is shown, with names, as a canvas of a width and height [pixels]; the page's own stays. */
  picture(width, height) {
    const made = document.createElement("canvas");
    Object.assign(made, { width, height });
    this.renderer.setPixelRatio(1);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.scene.background = this.colour("--stage");
    this.renderer.render(this.scene, this.camera);
    const context = made.getContext("2d");
    context.drawImage(this.renderer.domElement, 0, 0);
    this.labels.write(context, this.camera, width / PICTURE);
    this.drawNow();
    return made;
  }

  /** Calls `f` after each frame. */
  onFrame(f) {
    this.framed.push(f);
  }

  fit() {
    const { clientWidth, clientHeight } = this.canvas;
    const ratio = Math.min(devicePixelRatio * DENSITIES[this.level], 2);
    if (clientWidth && (this.canvas.width !== Math.floor(clientWidth * ratio)
      || this.canvas.height !== Math.floor(clientHeight * ratio))) {
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(clientWidth, clientHeight, false);
      this.camera.aspect = clientWidth / clientHeight;
      this.camera.updateProjectionMatrix();
    }
  }

  /** The boxes of what should be seen at first: robots as a whole, and movable bodies. */
  wanted() {
    const things = [...this.things.values()];
    const robots = this.view.robots.map((robot) => boxOf(things.filter((each) => each.robot === robot)));
    return [...robots, ...things.filter((each) => each.described.movable).map((each) => each.box())];
  }

  /** The boxes of all regions. */
  regions() {
    return [...this.things.values()].filter((each) => each.kind === "region").map((each) => each.box());
  }

  /** The boxes of all links and bodies. */
  solids() {
    return [...this.things.values()].filter((each) => each.kind !== "region").map((each) => each.box())
      .filter((each) => !each.isEmpty());
  }

  /** The box of all links and bodies. */
  solidBox() {
    return boxOf([...this.things.values()].filter((each) => each.kind !== "region"));
  }

  /** A colour of the style sheet. */
  colour(name) {
    return new Color(getComputedStyle(this.canvas).getPropertyValue(name).trim());
  }

  // ------------------------------------------------------------------------------------------------------ picking
  /** Calls `f` with the name of what is clicked, or null beside everything. */
  onPick(f) {
    this.pickers.push(f);
  }

  listen() {
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    let pressed = null;
    this.canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
    this.canvas.addEventListener("pointerup", (event) => {
      if (pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < 4) {
        const name = this.at(event)?.name ?? null;
        this.pickers.forEach((f) => f(name));
      }
      pressed = null;
    });
  }

  /** What is seen at a pointer: its name and the point in the world; null if nothing is there. */
  at(event) {
    const frame = this.canvas.getBoundingClientRect();
    const place = new Vector2(2 * (event.clientX - frame.left) / frame.width - 1,
      1 - 2 * (event.clientY - frame.top) / frame.height);
    const ray = new Raycaster();
    ray.setFromCamera(place, this.camera);
    const solids = [...this.things.values()].flatMap((thing) => thing.solids());
    const hit = ray.intersectObjects(solids, false)[0];
    return hit ? { name: hit.object.userData.name, point: hit.point } : null;
  }
}

function boxOf(things) {
  return boxed(things.reduce((whole, each) => whole.union(each.box()), new Box3()));
}

/** A box, or one of a metre if it is empty. */
function boxed(box) {
  return box.isEmpty() ? box.set(new Vector3(-0.5, -0.5, 0), new Vector3(0.5, 0.5, 1)) : box;
}
