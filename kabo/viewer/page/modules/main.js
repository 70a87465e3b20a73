// Starts the page: reads the document, builds the shell and the stage, and shows each part that is there.
import { typedArrays } from "kabo/arrays.js";
import { Shell } from "kabo/shell.js";
import { Stage } from "kabo/stage.js";
import * as explanation from "kabo/explanation_panel.js";
import * as findings from "kabo/findings_panel.js";
import * as live from "kabo/live_panel.js";
import * as plan from "kabo/plan_panel.js";
import * as report from "kabo/report_panel.js";
import * as run from "kabo/run_panel.js";
import * as scene from "kabo/scene_panel.js";

/** The panels in the order of their tabs, each with whether a document has something for it. */
const PANELS = [
  [plan, (shown) => shown.plan !== null],
  [run, (shown) => shown.run !== null],
  [live, (shown) => shown.live !== null],
  [report, (shown) => shown.report !== null],
  [explanation, (shown) => shown.explanation !== null],
  [scene, (shown) => shown.scene !== null],
  [findings, (shown) => shown.findings.length > 0],
];

/** Whether the browser has WebGL 2. */
function canDraw() {
  return document.createElement("canvas").getContext("webgl2") !== null;
}

/**
 * Shows a document in this page.
 * @param {object} shown the view document
 * @param {ArrayBuffer} block its arrays
 */
export async function start(shown, block) {
  let ready;
  const kabo = { document: shown, stage: null, player: null, ready: new Promise((done) => { ready = done; }) };
  window.kabo = kabo;
  const arrays = typedArrays(shown.arrays, block);
  document.getElementById("waiting")?.remove();
  const shell = new Shell(document.body, shown);
  kabo.shell = shell;
  if (shown.scene !== null && canDraw()) {
    kabo.stage = new Stage(shell.canvas, shown.scene, arrays);
    shell.onTheme(() => kabo.stage.setVisible("grid", kabo.stage.visible.get("grid")));
  } else if (shown.scene !== null) {
    shell.withoutStage("This browser draws no 3D (WebGL 2): only the panels are shown.");
    shown = { ...shown, scene: null };
  }
  for (const [panel, isThere] of PANELS) {
    if (isThere(shown)) {
      await panel.show(shown, kabo.stage, shell, arrays);
    }
  }
  shell.begin();
  kabo.stage?.drawNow();
  document.documentElement.dataset.ready = "yes";
  ready();
}
