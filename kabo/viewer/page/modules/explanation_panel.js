// The panel of a page's explanation.

/** Adds what the document has of the explanation to the shell. */
export function show(shown, stage, shell, arrays) {
}
