// What moving things sweep in the present segment, as translucent polyhedra on the stage.
import { ConvexGeometry, Group, Mesh, MeshLambertMaterial, Vector3 } from "three";
import { make } from "kabo/elements.js";

const COLOUR = 0x2c9a4b;
const OPACITY = 0.16;

export class Sweeps {
  /**
   * @param {object} plan the PlanView
   * @param {object|null} stage
   * @param {TypedArray[]} arrays
   */
  constructor(plan, stage, arrays) {
    this.stage = stage;
    this.arrays = arrays;
    this.material = new MeshLambertMaterial({ color: COLOUR, transparent: true, opacity: OPACITY, depthWrite: false });
    this.box = make("input", { type: "checkbox", onchange: () => this.show(this.node, this.time) });
    const title = "polyhedra that contain all that moves in this segment; they stick out farther than what planning uses";
    this.element = make("label", { title, hidden: !stage || !plan.nodes.some((node) => node.sweeps) }, [this.box, " swept volume"]);
  }

  /** Shows what is swept in the segment of a node that is under way at a time, if that is wanted. */
  show(node, time) {
    [this.node, this.time] = [node, time];
    const sweeps = (this.box.checked && node?.sweeps) || [];
    const now = sweeps.find((sweep) => time < sweep.to - 1e-9) ?? sweeps.at(-1) ?? null;
    if (now !== this.shown) {
      this.shown = now;
      this.stage?.overlay("sweep", now && this.solids(now));
    }
  }

  solids({ step, origin, sizes, corners }) {
    const numbers = this.arrays[corners.array];
    const group = new Group();
    let at = 0;
    for (const size of sizes) {
      const points = Array.from({ length: size }, (_, k) => new Vector3(...origin.map((low, axis) => low + step * numbers[3 * (at + k) + axis])));
      at += size;
      group.add(new Mesh(new ConvexGeometry(points), this.material));
    }
    return group;
  }
}
