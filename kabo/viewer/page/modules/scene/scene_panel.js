// The panel of the scene: which layers are shown, what was clicked, the joints, the contacts that are allowed.
import { make } from "kabo/elements.js";
import { robotControls } from "kabo/joints.js";

/** The layers that can be shown, each with the key that does so, and what it is. */
const LAYERS = [
  ["original", "m", "meshes"],
  ["enclosing", "e", "enclosing parts"],
  ["hull", "h", "hulls"],
  ["regions", "r", "regions"],
  ["frames", "a", "frames"],
  ["features", "u", "features"],
  ["sensors", "v", "view cones"],
  ["labels", "n", "names"],
  ["grid", "g", "grid"],
];

/** Adds the panel of the document's scene. */
export function show(shown, stage, shell) {
  const place = make("div", { className: "scene" }, [
    layers(shown.scene, stage, shell), chosen(shown.scene, stage), ...robotControls(shown.scene, stage),
    ...contacts(shown.scene, stage)]);
  shell.addPanel("scene", "Scene", place);
  prints(stage);
  shell.onKey("f", "look at the whole scene", () => stage.look([]));
  if (shown.plan === null) { // there 0 shows the whole plan, and Home is the beginning
    shell.onKey("0", "back to the start", () => stage.setState(shown.scene.start));
  }
  shell.onKey("Escape", "nothing chosen", () => {
    stage.highlight([], null);
    stage.focus(null);
  });
  shell.note("drag", "turn the view; with the right button: move it; wheel: nearer");
  shell.note("shift + drag", "move the joint that carries a link");
  shell.note("click", "what a link or body is");
}

/** Puts a picture into the page while it is printed: on paper a canvas may be empty. */
function prints(stage) {
  let picture = null;
  addEventListener("beforeprint", () => {
    picture?.remove();
    picture = stage.picture(1600, 900);
    picture.className = "printed";
    stage.canvas.parentElement.append(picture);
  });
  addEventListener("afterprint", () => { picture?.remove(); picture = null; });
}

// ---------------------------------------------------------------------------------------------------------- layers
function layers(scene, stage, shell) {
  const things = [...scene.robots.flatMap((robot) => robot.links), ...scene.bodies];
  const there = {
    enclosing: things.some((each) => each.shapes.enclosing), hull: things.some((each) => each.shapes.hull),
    regions: scene.regions.length > 0, sensors: scene.robots.some((robot) => robot.sensors.length > 0),
  };
  const boxes = LAYERS.filter(([layer]) => there[layer] ?? true).map(([layer, key, title]) => {
    const box = make("input", { type: "checkbox", checked: stage.visible.get(layer) ?? false,
      onchange: () => stage.setVisible(layer, box.checked) });
    box.dataset.layer = layer;
    shell.onKey(key, `show or hide ${title}`, () => box.click());
    return make("label", { title: `key ${key}` }, [box, title]);
  });
  const made = make("fieldset", { className: "layers" }, [make("legend", {}, ["Shown"]), ...boxes]);
  const told = enclosed(scene, things);
  return told ? make("div", {}, [made, make("p", { className: "dim" }, [told])]) : made;
}

/** How far enclosing parts stick out, or that some are missing. */
function enclosed(scene, things) {
  const missing = scene.unprepared ?? [];
  if (missing.length) {
    const few = missing.slice(0, 3).join(", ");
    const more = missing.length > 3 ? ` and ${missing.length - 3} more` : "";
    return `No convex parts are stored for ${few}${more}: kabo view --prepare makes them.`;
  }
  const most = Math.max(0, ...things.map((each) => each.deviation ?? 0));
  if (most === 0) {
    return null;
  }
  const divided = most > scene.epsilon ? "; parts are divided where a distance depends on them" : "";
  return `Planning uses the enclosing parts: they stick out of the meshes by at most ${millimetres(most)}${divided}. `
    + `Epsilon is ${millimetres(scene.epsilon)}.`;
}

function millimetres(metres) {
  return `${Number((1000 * metres).toPrecision(3))} mm`;
}

// ---------------------------------------------------------------------------------------------- what was clicked
function chosen(scene, stage) {
  const card = make("div", { className: "card", role: "status" }, [hint()]);
  stage.onPick((name) => {
    stage.focus(null);
    stage.highlight([], null);
    card.replaceChildren(...(name === null ? [hint()] : described(scene, stage, name)));
    if (name !== null) {
      stage.highlight([name], "chosen");
    }
  });
  return card;
}

function hint() {
  return make("span", { className: "dim" }, ["Click a link or a body to see what it is."]);
}

function described(scene, stage, name) {
  const thing = stage.things.get(name);
  const own = thing.described;
  const facts = [];
  if (thing.robot) {
    const joint = thing.robot.joints[own.joint];
    facts.push(joint ? `carried by ${joint.name}` : "fixed to the base");
  } else {
    facts.push(own.movable ? "movable" : "fixed");
    if (own.mass !== null) {
      facts.push(`${own.mass} kg`);
    }
  }
  facts.push(`${own.faces.toLocaleString("en")} triangles`);
  if (own.shapes.enclosing) {
    const count = own.shapes.enclosing.length;
    const parts = `${count} enclosing part${count === 1 ? "" : "s"}`;
    facts.push(own.deviation > 0 ? `${parts}, by at most ${millimetres(own.deviation)}` : `${parts}, exact`);
  }
  for (const key of ["grasps", "placements"]) {
    if (own[key]?.length) {
      facts.push(`${key}: ${own[key].join(", ")}`);
    }
  }
  const look = make("button", { type: "button", onclick: () => stage.look([name]) }, ["look"]);
  return [make("strong", {}, [name]), look, make("div", { className: "dim" }, [facts.join(" · ")])];
}

// -------------------------------------------------------------------------------------------------------- contacts
function contacts(scene, stage) {
  if (!scene.allowed.length) {
    return [];
  }
  const rows = scene.allowed.map((pair) => make("li", {}, [make("button", { type: "button", onclick: () => {
    stage.highlight([], null);
    stage.highlight(pair, "good");
    stage.focus(pair);
    stage.look(pair);
  } }, [pair.join(" – ")])]));
  return [make("details", { className: "contacts" }, [
    make("summary", {}, [`Allowed contacts (${scene.allowed.length})`]), make("ul", {}, rows)])];
}
