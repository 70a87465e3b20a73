"""Findings and counterfactuals as sentences for people."""

from collections import Counter
from collections.abc import Iterator, Sequence

from kabo.displays import counted
from kabo.explain.blame import blocking
from kabo.explain.findings import BodyRemoved, Change, Counterfactual, Finding, Row, SmallerEpsilon
from kabo.geometry_server.answers import BLOCKED_REASONS
from kabo.language.formulas import GroundCall
from kabo.planner.proofs.refused_calls import own_pair, own_text
from kabo.planner.proofs.wording import listed

EXHAUSTED = {
    "expansions": "No plan was found with as many nodes as allowed",
    "reasoning": "No plan was found (which is no proof: kabo does not reason by cases, and here a plan may need to)",
    "samples": "No plan was found",
    "time": "No plan was found before the time was up",
    "memory": "No plan was found with as much memory as allowed",
    "so_far": "No plan was found so far",
}
SHOWN_LEFT = 4  # calls or changes that a clause about what was not finished names
RESULTS = {
    "no_plan": "no plan, which is proven",
    "exhausted": "none was found, and that is no proof",
    "not_tried": "it could not be tried",
}


def main_finding(findings: Sequence[Finding], counterfactuals: Sequence[Counterfactual]) -> Finding | None:
    """The first finding that a successful change concerns; else the first finding; None if there is none."""
    for each in counterfactuals:
        about = [finding for finding in findings if _concerns(each.change, finding)]
        if each.result == "solved" and about:
            return about[0]
    return findings[0] if findings else None


def _concerns(change: Change, finding: Finding) -> bool:
    if isinstance(change, BodyRemoved):
        return any(name == change.body for name, _ in blocking(finding))
    if isinstance(change, SmallerEpsilon):
        return finding.because_of_epsilon > 0
    return finding.robot == change.robot and bool(finding.nearer)


def summary(
    verdict: str, budget: str | None, finding: Finding, others: Sequence[Counterfactual], epsilon: float
) -> list[str]:
    """Up to three sentences: the call that failed, the reason, and what tried changes would help."""
    failed = "can never succeed" if finding.proof else "never succeeded"
    if finding.handed_by:
        call, given = finding.call.arguments, listed(finding.handed_by, "or")
        failed = f"never succeeded after {given} had put {call[1]} down: {given} cannot hand it over to {call[0]}"
    if finding.successes:
        failed = f"failed in a state that mattered (and succeeded {counted(finding.successes, 'time')} elsewhere)"
    first = "There is no plan, which is proven" if verdict == "proved" else EXHAUSTED[budget or "samples"]
    return [f"{first}: {finding.call} {failed}.", why(finding, epsilon), *best(others)]


def why(finding: Finding, epsilon: float) -> str:
    """A sentence with the most frequent reason of a finding's refused attempts.

    For example "It was blocked by crate in 388 of 400 samples (97 %)."
    """
    reasons = Counter[str]()
    for row in finding.rows:
        reasons[row.reason] += row.count
    reason = reasons.most_common(1)[0][0] if reasons else "empty_family"
    if reason not in BLOCKED_REASONS:
        if reason == "out_of_reach" and finding.missing:
            floor = ""
            if finding.floor is not None:
                floor = f", wherever on {finding.floor} the base of {finding.robot} stands"
            told = "; ".join(measure.text for measure in finding.measures)
            return f"It is out of reach by {finding.missing:.3f} m{floor}{f': {told}' if told else ''}."
        return _sentence(finding.message.partition(": ")[2] or finding.message, finding.call)
    wide = _too_wide(finding)
    if reason == "collision" and wide is not None:
        return _sentence(wide, finding.call)
    kept = next((each.said for each in finding.measures if each.decides_alone and not each.epsilon), None)
    if kept is not None:
        return f"It was refused only because of the distance that is to be kept: {kept}."
    share = finding.because_of_epsilon
    samples = _of(share, finding.refused)
    if 2 * share > finding.refused:
        alone = next((f": {each.said}" for each in finding.measures if each.epsilon), "")
        return (
            f"It was refused only because of epsilon = {epsilon:g} in {samples}{alone}: exact geometry would pass."
        )
    body, count = blocking(finding)[0] if blocking(finding) else (None, 0)
    if body is None:
        return f"No way was found in {_of(reasons[reason], finding.refused)}."
    too = f", {share} of them only because of epsilon = {epsilon:g}" if share else ""
    how = "hidden" if reason == "hidden" else "blocked"
    own = own_pair(body, ((row.between, row.count) for row in finding.rows if row.between))
    itself = "" if own is None else f", most often {own_text(own, finding.measures)}"
    by = body if own is None else f"{body} itself"
    return f"It was {how} by {by} in {_of(count, finding.refused)}{too}{itself}."


def _sentence(said: str, call: GroundCall) -> str:
    """A clause as a sentence; a name such as `cup_1` with which it begins keeps its spelling."""
    first = said.partition(" ")[0]
    is_name = "_" in first or first in map(str, call.arguments)
    return f"{said}." if is_name else f"{said[0].upper()}{said[1:]}."


def _too_wide(finding: Finding) -> str | None:
    """The width of the object beyond the gripper's opening, if the object itself is what is hit most often."""
    hit = finding.rows[0].between or ()
    found = (each for each in finding.measures if each.name.partition(".")[0] in hit)
    return next((each.text for each in found), None)


def _of(count: int, total: int) -> str:
    return f"{count} of {counted(total, 'sample')} ({100.0 * count / max(total, 1):.0f} %)"


def not_repeated(findings: Sequence[Finding]) -> list[str]:
    """A clause about the failed calls whose attempts were only counted; empty if all were looked at."""
    left = [str(finding.call) for finding in findings if not finding.repeated]
    if not left:
        return []
    return [f"whether epsilon alone, or which body alone, is in the way of {listed(left, 'and', SHOWN_LEFT)}"]


def not_tried(left: Sequence[Change]) -> list[str]:
    """A clause about the changes that there was no time to try; empty if there are none."""
    return [f"what one change would do: {listed(map(str, left), 'and', SHOWN_LEFT)}"] if left else []


def best(others: Sequence[Counterfactual]) -> list[str]:
    """A one-sentence list: the change that helps most, or that no change helps; empty if no change was tried."""
    if not others:
        return []
    first = others[0]
    if first.result == "solved" and first.plan_actions is not None:
        text = str(first.change)
        return [f"{text[0].upper()}{text[1:]} a plan of {counted(first.plan_actions, 'action')} exists."]
    return [f"No plan was found {listed((str(each.change) for each in others), 'nor')}."]


def report(findings: Sequence[Finding], others: Sequence[Counterfactual]) -> Iterator[str]:
    """The lines of the report after the summary: the findings, then the results of the changes."""
    if findings:
        yield "\nProcedures that failed:"
    for finding in findings:
        answers = f"{counted(finding.successes, 'success')}, " if finding.successes else ""
        yield f"  - {finding.call}, {answers}{finding.refused} of {counted(finding.attempts, 'sample')} refused:"
        for row in finding.rows:
            yield f"      {row.count} {_row(row)}"
        yield from (f"      {measure.text}" for measure in finding.measures if measure.text not in finding.message)
        for name, count in finding.freed:
            yield f"      {count} of them pass without {name}"
        if finding.proof:
            yield f"      proven: {finding.message.partition(': ')[2] or finding.message}"
    if others:
        yield "\nWhat one change would do:"
    for each in others:
        actions = f"a plan of {counted(each.plan_actions or 0, 'action')}"
        yield f"  - {each.change}: {RESULTS.get(each.result, actions)}{f': {each.why}' if each.why else ''}"


def _row(row: Row) -> str:
    between = "" if row.between is None else f" of {row.between[0]} and {row.between[1]}"
    if row.reason == "no_path":
        between = "" if row.between is None else f", mostly for {row.between[0]} and {row.between[1]}"
    far = "" if row.missing is None else f" by {row.missing:.3f} m"
    only = f", {row.because_of_epsilon} of them only because of epsilon" if row.because_of_epsilon else ""
    said = "" if row.said is None else f": {row.said}"
    return f"{row.reason.replace('_', ' ')}{far}{between}{only}{said}"
