"""What a report of a verification says as text."""

from kabo.verify.report import Least, Report


def test_the_least_distance_measured_is_not_told_as_the_least_there_is() -> None:
    text = str(Report(least=Least(0.02082, ("arm.hand", "wall"), "n0", 1.5)))
    expected = (
        "least distance measured: 20.82 mm (arm.hand and wall, n0 at 1.500 s); elsewhere they may come nearer"
    )
    assert expected in text.splitlines()
