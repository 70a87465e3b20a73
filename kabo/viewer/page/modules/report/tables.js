// Tables and folded sections of the panels.
import { make } from "kabo/elements.js";

/**
 * A table without its empty columns.
 * @param {string[]} header
 * @param {(Node|string|string[])[][]} rows the cells; a list is one line each
 * @param {string} [numbers] the name of the column that holds numbers
 */
export function table(header, rows, numbers = "cost") {
  const told = header.map((_, k) => k).filter((k) => k === 0 || rows.some((row) => !isEmpty(row[k])));
  const head = told.map((k) => make("th", { scope: "col", className: header[k] === numbers ? "n" : "" }, [header[k]]));
  const body = rows.map((row) => make("tr", {}, told.map((k) => (
    make("td", { className: header[k] === numbers ? "n" : "" }, lines(row[k]))))));
  const made = make("table", {}, [make("thead", {}, [make("tr", {}, head)]), make("tbody", {}, body)]);
  return make("div", { className: "wide" }, [made]);
}

function isEmpty(cell) {
  return cell === "" || cell === null || cell === undefined || (Array.isArray(cell) && cell.length === 0);
}

function lines(cell) {
  if (!Array.isArray(cell)) {
    return isEmpty(cell) ? [] : [cell];
  }
  return cell.flatMap((line, k) => (k ? [make("br"), line] : [line]));
}

/** The lines of a cell for a comment, and for what it changes in the scene. */
export function told(comment, changes) {
  return [...(comment ? [comment] : []), ...changes.map((line) => make("span", { className: "dim" }, [line]))];
}

/** A section that can be folded; its content is made when it is first unfolded, by a reader or by `unfold()`. */
export function folded(title, content, { open = false, className = "" } = {}) {
  const summary = make("summary", {}, Array.isArray(title) ? title : [title]);
  const made = make("details", { className }, [summary]);
  let filled = false;
  const fill = () => {
    if (made.open && !filled) {
      filled = true;
      summary.after(...content());
    }
  };
  made.addEventListener("toggle", fill);
  made.unfold = () => {
    made.open = true;
    fill();
  };
  if (open) {
    made.unfold();
  }
  return made;
}
