// The planned poses of what is not where the plan has it: translucent shapes beside those that are measured.
import { Group, Matrix4, Mesh, MeshBasicMaterial } from "three";
import { scenePoses } from "kabo/kinematics.js";

const SEEN = 1e-4; // metres or parts of a turn by which a thing must be off to be shown twice
const COLOUR = 0x2f7de1;

export class Ghost {
  constructor(stage) {
    this.stage = stage;
    this.material = new MeshBasicMaterial({ color: COLOUR, transparent: true, opacity: 0.35, depthWrite: false });
  }

  /** Shows where things would be in a state, as far as they are elsewhere; null: none. */
  show(planned) {
    if (planned === null) {
      this.stage.overlay("ghost", null);
      return;
    }
    const group = new Group();
    for (const [name, pose] of scenePoses(this.stage.view, planned)) {
      const thing = this.stage.things.get(name);
      const here = this.stage.poseOf(name);
      const shape = thing?.layers.get("original");
      if (shape?.geometry && here && pose.some((value, k) => Math.abs(value - here[k]) > SEEN)) {
        const made = new Mesh(shape.geometry, this.material);
        made.matrixAutoUpdate = false;
        made.matrix.copy(new Matrix4().set(...pose));
        group.add(made);
      }
    }
    this.stage.overlay("ghost", group.children.length ? group : null);
  }
}
