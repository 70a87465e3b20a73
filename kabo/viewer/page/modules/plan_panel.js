// The panel of a page's plan.

/** Adds what the document has of the plan to the shell. */
export function show(shown, stage, shell, arrays) {
}
