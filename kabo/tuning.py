"""The tuned constants of the search, each with its meaning and unit; `benchmarks/tuning.py` varies them.

No constant decides whether an answer is right. The constants determine the order of the search and when one method
gives way to the next, so a change costs or saves time, and may lead to another plan. They are read here when
needed.
"""

# ------------------------------------------------------------------------- weak plans: one way to the goal
MAX_SERIAL_EXPANSIONS = 2000  # expansions for one more conjunct of the goal, before all are searched for at once
PREFERRED_QUEUE_TURNS = 1000  # turns that the queue of preferred actions gets whenever the estimate improves
EXPANSIONS_WITHOUT_BOUNDS = 200  # expansions of A* before it computes lower bounds: loading them takes as long
VISITS_GROWTH = 4  # factor of how often depth-first search may visit a state of knowledge, after each failure
MAX_REMEMBERED_ESTIMATES = 20_000  # estimates of the delete relaxation that are kept

# ------------------------------------------------------------ contingent plans: every outcome of sensing
SECOND_SEARCH_EXPANSIONS = 150  # a plan found with at most as many expansions is searched again, for a smaller one
MAX_FAILED_CHOICES = 200  # failed choices after which `best` starts over and assumes other outcomes of sensing
FAILED_CHOICES_BEFORE_FIXPOINT = 500  # failed choices after which the fixpoint over all nodes takes its turn
FAILED_CHOICES_GROWTH = 4  # factor of that number after each turn
MIN_FIXPOINT_NODES = 10_000  # nodes that one turn of the fixpoint looks at, at least
MAX_DEAD_STATES = 200  # states without a plan that every new state is compared with

# ---------------------------------------------------- finite-domain tasks, and what was learnt compiled into them
MAX_ALTERNATIVES = 64  # alternatives of one condition: a task with more is left to the searches over knowledge
MAX_DISJUNCTIONS = 4  # parts of one conjunction that have several alternatives each; likewise
MAX_LINEAR_EXPANSIONS = (
    20_000  # expansions for a plan that senses nothing, before any plan that branches is searched for
)
MAX_CHEAPEST_EXPANSIONS = 3_000  # expansions of A*, where refusals were learnt, before any plan is searched for
ACTION_PRICE = 10  # what a unit of an action's cost counts beside the four prices below
RETRY_PRICE = 7  # for each further attempt at a call
SUSPICION_PRICE = 30  # for a call where what was in its way is still there
REFUSAL_PRICE = 2  # for each refusal of a call so far
MAX_REFUSAL_PRICE = 20  # for all refusals of a call together
MAX_CONDITIONS = 48  # conditions under which one call is not refused: of more, some are left out

# ------------------------------------------------------------------------------------ asking geometry lazily
MAX_FAILED_SKELETONS = 100  # refused skeletons before more samples are drawn
FAILED_SKELETONS_GROWTH = 4  # factor of that number at each further level of effort
MAX_REPAIRS = 24  # other attempts at earlier calls of one skeleton, where plans branch
ATTEMPTS_PER_EFFORT = 4  # answers of one call that may be asked for, at each level of effort
BLOCKING_SHARE = 0.2  # share of all collisions from which on a body counts as in the way of a call
FULL_DEPENDENCE_EFFORT = 2  # level of effort from which on every call is taken to depend on all components
MIN_FAILED_CALLS = 60  # failed calls, and
FAILED_CALL_SHARE = 0.4  # their share of all calls, after which eager asking begins, if plans branch

# ----------------------------------------------------------------------------------- asking geometry eagerly
EAGER_EXPANSIONS = 100  # expansions before calls are asked for more answers each
EAGER_EXPANSIONS_GROWTH = 4  # factor of that number at each further level of effort
EAGER_ATTEMPTS_PER_EFFORT = 2  # more answers of each call, at each level of effort

# ---------------------------------------------------------------- external procedures, which a caller supplies
MAX_SEEDS = 16  # calls with different seeds before arguments count as refused
MIN_EXTERNAL_CALLS = 8  # calls of one procedure, and
EXTERNAL_FAILURE_SHARE = 0.35  # the share of them that failed, from which on all its calls are asked at once

# ------------------------------- plain Python before compiled code is loaded, which takes half a second once
PLAIN_BREADTH_FIRST_STATES = 40_000  # states that breadth-first search generates
PLAIN_ASTAR_STATES = 5000  # states that A* generates
PLAIN_NOVELTY_STATES = 4000  # states that the search by novelty enters, but at most as many as have together
PLAIN_NOVELTY_PAIRS = 200_000  # pairs of variables, and operators
PLAIN_RELAXATION_VISITS = 600_000  # visits of operators' conditions and adds by relaxed plans
PLAIN_MUTEX_VARIANTS = 1500  # operators times their conditional effects, for mutually exclusive facts

# ------------------------------------------------------------------------------ limits of finite-domain search
MAX_MUTEX_FACTS = 6000  # facts of a task whose mutually exclusive pairs are computed
MAX_MUTEX_WORK = 400_000_000  # facts times variants of operators of such a task
NOVELTY_PAIR_BYTES = 512 << 20  # bytes for the pairs of facts that a search has seen
