"""The exit codes of every command, as scripts rely on them (docs/reference/commands.md)."""

DONE = 0
DEFECT = 1
BAD_INPUT = 2
PROVEN_NO_PLAN = 3
NO_PLAN = 4
VERIFICATION_FAILED = 5
SERVICE = 6
STOPPED = 7
INTERRUPTED = 130  # 128 + SIGINT, as shells count

BY_STATUS = {"solved": DONE, "no_plan": PROVEN_NO_PLAN, "exhausted": NO_PLAN, "invalid": BAD_INPUT}
BY_CODE = {
    "bad_request": BAD_INPUT,
    "deadline": NO_PLAN,
    "failed": DEFECT,
    "forbidden": BAD_INPUT,
    "id_reused": BAD_INPUT,
    "too_large": BAD_INPUT,
}
