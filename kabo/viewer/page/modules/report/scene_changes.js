// How a change of the scene is drawn over it: both as it is and as it would be.
import {
  ArrowHelper, Box3, Box3Helper, BufferGeometry, Color, Group, LineBasicMaterial, LineSegments, Mesh,
  MeshLambertMaterial, Vector3,
} from "three";

const COLOUR = 0x2c9a4b;

export class Changes {
  /** @param {object} stage @param {object} view the SceneView @param {object} samples what else is highlighted */
  constructor(stage, view, samples) {
    Object.assign(this, { stage, view, samples, button: null });
  }

  /** Shows a change, or the scene as it is if this change is shown already. */
  toggle(change, button) {
    const again = this.button === button;
    this.button?.setAttribute("aria-pressed", "false");
    this.samples.unmark();
    this.stage.overlay("change", null);
    this.button = again ? null : button;
    if (!again) {
      button.setAttribute("aria-pressed", "true");
      this.stage.setState(this.view.start);
      this.draw(change);
    }
  }

  draw(change) {
    if (change.remove !== undefined) {
      this.samples.mark([change.remove], "good");
      this.stage.overlay("change", this.crossed(change.remove));
    } else if (change.robot !== undefined) {
      this.stage.overlay("change", this.shifted(change.robot, new Vector3(...change.by)));
    } else {
      this.stage.overlay("change", this.grown(change.region, change.grow));
    }
  }

  /** A box with its diagonals about a body that is left out. */
  crossed(name) {
    const box = this.boxOf([name]);
    const made = new Group();
    made.add(boxed(box));
    const { min, max } = box;
    const corners = [min, max, new Vector3(max.x, min.y, min.z), new Vector3(min.x, max.y, max.z)];
    made.add(new LineSegments(new BufferGeometry().setFromPoints(corners), material()));
    return made;
  }

  /** The robot where it would stand, and an arrow from where it stands. */
  shifted(robot, by) {
    const made = new Group();
    const ghostly = new MeshLambertMaterial({ color: COLOUR, transparent: true, opacity: 0.45, depthWrite: false });
    for (const thing of this.stage.named([robot])) {
      for (const solid of thing.solids()) {
        const ghost = new Mesh(solid.geometry, ghostly);
        ghost.matrixAutoUpdate = false;
        ghost.matrix.copy(thing.group.matrix);
        ghost.matrix.elements[12] += by.x;
        ghost.matrix.elements[13] += by.y;
        ghost.matrix.elements[14] += by.z;
        made.add(ghost);
      }
    }
    const base = this.view.robots.find((each) => each.name === robot).links[0].name;
    const pose = this.stage.poseOf(`${robot}.${base}`);
    const from = new Vector3(pose[3], pose[7], pose[11]);
    const length = by.length();
    made.add(new ArrowHelper(by.clone().normalize(), from, length, COLOUR, 0.3 * length, 0.15 * length));
    return made;
  }

  /** The box about a region that is larger. */
  grown(name, by) {
    return boxed(this.boxOf([name]).expandByVector(new Vector3(by, by, 0)));
  }

  boxOf(names) {
    this.stage.scene.updateMatrixWorld(true);
    return this.stage.named(names).reduce((whole, thing) => whole.union(thing.box()), new Box3());
  }
}

function boxed(box) {
  return new Box3Helper(box, new Color(COLOUR));
}

function material() {
  return new LineBasicMaterial({ color: COLOUR });
}
