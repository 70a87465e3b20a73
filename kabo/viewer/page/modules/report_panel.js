// The panel of a page's report.

/** Adds what the document has of the report to the shell. */
export function show(shown, stage, shell, arrays) {
}
