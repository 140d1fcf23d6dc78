"""What each figure of results/ shows, where it is drawn and from what: captions for report and site."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

COMMANDS = {
    "paper": "crawler-bench reproduce", "benchmark": "crawler-bench benchmark",
    "readings": "crawler-bench readings", "search": "crawler-bench readings --search", "speed": "make speed",
}  # fmt: skip
_PAPER, _BENCHMARK = "crawler_bench/paper/", "crawler_bench/benchmark/figures/"


@dataclass(frozen=True)
class Figure:
    """A figure in words.

    Attributes:
        title: a few words.
        shows: one or two sentences for someone who sees it first, or who cannot see it.
        code: where it is drawn, file:function.
        data: CSV files that hold what it draws; empty where only the run folders do.
    """

    title: str
    shows: str
    code: str = ""
    data: tuple[str, ...] = ()


# By folder and file name without suffix.
FIGURES = {
    "paper/fig_1a": Figure(
        "Fig. 1A: the crawler",
        "The model: segments of spring and damper, each with a muscle that one neuron drives, on ground that "
        "holds a node back more strongly than it lets it slide forward.",
        f"{_PAPER}figure_1.py:fig_1a",
    ),
    "paper/fig_2a": Figure(
        "Fig. 2A: the regularized gait",
        "Position and strain of each segment and force of each muscle against time. One wave of contraction "
        "after the other travels from tail to head.",
        "crawler_bench/output/kymographs.py:gait",
    ),
    "paper/fig_2b": Figure(
        "Fig. 2B: the unregularized gait",
        "The same for a typical run that pays nothing for muscle activity.",
        "crawler_bench/output/kymographs.py:gait",
    ),
    "paper/fig_2c": Figure(
        "Fig. 2C: the learned policies",
        "Which neuron each policy switches on at each observation. The diagonal is nearest-neighbour wiring.",
        f"{_PAPER}figure_2.py:policies", ("runs.csv",),
    ),
    "paper/fig_3a": Figure(
        "Fig. 3A: power",
        "Power of each node in the course of a cycle, for both gaits.",
        f"{_PAPER}figure_3.py:power_by_phase",
    ),
    "paper/fig_3b": Figure(
        "Fig. 3B: duration of a cycle",
        "How long a wave of contraction takes through the body: all cycles, and the mean of each run.",
        f"{_PAPER}figure_3.py:cycle_durations", ("cycles.csv",),
    ),
    "paper/fig_3c": Figure(
        "Fig. 3C: speed against noise",
        "Speed when the sensed strains err by up to s, for both gaits and for random action.",
        f"{_PAPER}figure_3.py:speed_against_noise", ("evaluations.csv",),
    ),
    "paper/fig_s1": Figure(
        "Fig. S1: before learning",
        "Speed, strain and muscle force while every neuron is equally likely to be on.",
        f"{_PAPER}figure_s1.py:untrained",
    ),
    "paper/fig_learning": Figure(
        "Learning",
        "How the wiring emerges: values of one run of each gait at five moments, and the number of entries "
        "off the diagonal in all runs.",
        f"{_PAPER}figure_2.py:learning",
    ),
    "benchmark/speeds": Figure(
        "Speed of every agent",
        "Speed of the frozen policies without noise; a dot is a training run.",
        f"{_BENCHMARK}scores.py:speeds", ("runs.csv",),
    ),
    "benchmark/cycle_durations": Figure(
        "Duration of a cycle, every agent",
        "How long a wave of contraction takes, for the agents whose policies make waves.",
        f"{_BENCHMARK}scores.py:cycle_durations", ("cycles.csv", "runs.csv"),
    ),
    "benchmark/noise": Figure(
        "Speed against noise, every agent",
        "The comparison of Fig. 3C for every agent and mode, with the noise from which on the regularized "
        "policy is the faster one.",
        f"{_BENCHMARK}curves.py:noise_curves", ("evaluations.csv",),
    ),
    "benchmark/learning_curves": Figure(
        "Learning curves",
        "Speed while learning, exploration included, against decisions.",
        f"{_BENCHMARK}curves.py:learning_curves", ("curves.csv",),
    ),
    "benchmark/policies": Figure(
        "What each agent learned",
        "Mean policy of every agent and mode: one row per observation, one column per neuron.",
        f"{_BENCHMARK}policies.py:policy_matrices", ("policy_tables.csv",),
    ),
    "benchmark/gaits": Figure(
        "Gaits of the agents",
        "Strain of every segment against time, for a typical run of every agent.",
        f"{_BENCHMARK}policies.py:gaits",
    ),
    "benchmark/softening": Figure(
        "From the likeliest actions to random action",
        "Speed of the learned policies when their choice is made more or less random, and how many "
        "observations stop the body for good when it is not random at all.",
        f"{_BENCHMARK}curves.py:softening", ("softening.csv", "stuck.csv"),
    ),
    "benchmark/traps": Figure(
        "Traps",
        "Pairs of observation and action after which the body comes to rest and stays there.",
        f"{_BENCHMARK}policies.py:trap_matrix",
    ),
    "readings/profiles": Figure(
        "The score along each open field",
        "How well the claims are met when one field that the paper leaves open is varied; lower is better.",
        "crawler_bench/readings/figures.py:profiles", ("readings.csv",),
    ),
    "readings/distances": Figure(
        "Every reading against every claim",
        "How far each reading is from each group of claims, in units of its tolerance; lower is better.",
        "crawler_bench/readings/figures.py:distances", ("claims.csv",),
    ),
    "readings/strength": Figure(
        "How the strength of a muscle is split",
        "Every reading by the two factors whose product is the strength of a muscle, coloured by its score; "
        "lower is better.",
        "crawler_bench/readings/figures.py:strength", ("readings.csv",),
    ),
    "readings/conclusion": Figure(
        "What the conclusion depends on",
        "Share of runs that end on the diagonal, make a wave and keep it localized, when a value that the "
        "paper gives is varied.",
        "crawler_bench/readings/figures.py:conclusion", ("ends.csv",),
    ),
    "search/front": Figure(
        "Score against the number of free constants",
        "Every completed trial of the search; lower is better on both axes.",
        "crawler_bench/readings/search/figures.py:front", ("trials.csv", "finals.csv"),
    ),
    "search/trapping": Figure(
        "Slow random action and the wiring, in one reading",
        "Share of runs that end on the diagonal against the speed of random action, trial by trial.",
        "crawler_bench/readings/search/figures.py:trapping", ("trials.csv", "again.csv", "finals.csv"),
    ),
    "speed/history": Figure(
        "Speed over the commits measured",
        "Every measurement that has a goal, over the commits measured; goals are dashed.",
        "speed/figures.py:over_commits", ("measurements.csv", "commits.csv"),
    ),
    "speed/ratios": Figure(
        "Speed relative to peers",
        "How many times as fast as each peer: median and range over repeats; bars are goals.",
        "speed/figures.py:ratios", ("measurements.csv",),
    ),
    "speed/segments": Figure(
        "Cost of a decision over the number of segments",
        "Time of one decision on one core, for each integrator; lower is better.",
        "speed/figures.py:cost", ("measurements.csv",),
    ),
    "speed/batch": Figure(
        "Cost of a decision over the number of crawlers in a batch",
        "Time of one decision of one crawler on one core, for each integrator; lower is better.",
        "speed/figures.py:cost", ("measurements.csv",),
    ),
}  # fmt: skip


def described(kind: str, name: str) -> Figure:
    """The words for a figure; its name alone for one that is not in the list."""
    return FIGURES.get(f"{kind}/{name}") or Figure(name.replace("_", " ").capitalize(), "")


def pictures(folder: Path, kind: str) -> Iterator[tuple[str, Figure, Path]]:
    """Name, words and file of every figure in a folder: listed ones first, in the order of the list."""
    listed = [name.removeprefix(f"{kind}/") for name in FIGURES if name.startswith(f"{kind}/")]
    found = sorted(path.stem for path in folder.glob("*.png"))
    order = [name for name in listed if name in found] + [name for name in found if name not in listed]
    for name in order:
        yield name, described(kind, name), folder / f"{name}.png"
