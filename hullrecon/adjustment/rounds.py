# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Rounds of the adjustment: choose and weight measurements, solve, re-estimate sigmas."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np

from hullrecon import native
from hullrecon.adjustment.options import AdjustOptions, Strategy
from hullrecon.adjustment.partition import join
from hullrecon.adjustment.partition.plan import Plan, plan_parts, whole
from hullrecon.adjustment.problem import intrinsics, iteration_history, lens, selection, weighting
from hullrecon.adjustment.problem.assembly import Selection, assemble, state_from_unknowns
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.state import State, Weights
from hullrecon.errors import StageError
from hullrecon.findings.package import DVL_ALONE
from hullrecon.memory import return_free_memory
from hullrecon.records.iterations import reached_cost
from hullrecon.rig import Rig
from hullrecon.typing import Array

if TYPE_CHECKING:
    from hullrecon.adjustment.cad_placement import Placement
    from hullrecon.adjustment.stereo_calibration import StereoContradiction
    from hullrecon.adjustment.suspects import Trial

Report = Callable[[str], None]
Made = TypeVar("Made")


class Keep(Protocol):
    """Make something that takes long, or load it by its label where an earlier run has made it."""

    def __call__(self, make: Callable[[], Made], label: str, /) -> Made: ...


def make_anew(make: Callable[[], Made], label: str) -> Made:
    """Make it without keeping anything. This is a `Keep`."""
    return make()


OUTLIER_SIGMAS = 5.0  # observations with larger residuals are left out
LEAST_MAX_PX = 2.0  # smallest outlier threshold of rounds before the last, as the path may be off
# Damping holds what many measurements share, a single camera's scale and the bends of a long path,
# far more than it holds the steps: with Ceres' 1e4 such a mode hardly moves while each iteration's
# gain falls below the tolerance.
INITIAL_RADIUS = 1e8
# Relative change of cost that ends the last solve, and the ones before it
FUNCTION_TOLERANCE = 1e-6
COARSE_TOLERANCE = 10 * FUNCTION_TOLERANCE
# About this number of landmarks enters the rounds before the last, at least one of each image
ANCHORS = 20_000
MIN_LANDMARKS = 20  # with fewer, a round is refused
log = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """The estimate that one round passes to the next."""

    measured: Measurements  # with the intrinsics and priors found so far
    state: State
    weights: Weights
    # Threshold of reprojection errors for an observation with the pixel sigma. Those of others
    # scale with their sigmas.
    max_px: float


@dataclass(frozen=True, kw_only=True)
class RoundResult:
    """The result of one solve."""

    chosen: Selection  # the measurements that entered
    weights: Weights  # sigmas and weights that were used
    plan: Plan  # how the problem was divided into parts
    start: native.Problem  # the problem at its start values
    problem: native.Problem  # the problem at its solution
    result: native.Result
    history: iteration_history.Round  # the solver's record
    after: Estimate  # with the solution, and with sigmas estimated from its residuals


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Whether a phase is accepted, and where it contradicts the dive package."""

    accepted: bool = True
    reason: str | None = None  # why it is not accepted, in words without a full stop
    stereo: StereoContradiction | None = None  # of the stereo rig's calibration
    # Share by which lengths by the DVL's velocities differ from lengths by all other measurements,
    # where a single camera cannot tell which are right
    length_conflict: float | None = None
    # Suspects that were tried where something contradicts the package, best explanation first
    suspects: tuple[Trial, ...] = ()


ACCEPTED = Verdict()


@dataclass(frozen=True, kw_only=True)
class Phase:
    """A phase of the adjustment: its rounds, its resulting estimate, and the verdict on it.

    Only the first and the last round are kept with their measurements, which take most memory.
    """

    history: tuple[iteration_history.Round, ...]
    start: native.Problem | None  # of the first round, as it began; None without rounds
    first: RoundResult | None  # None without rounds, or where they are not needed any more
    last: RoundResult | None  # None as `first`
    estimate: Estimate  # which the next phase starts from
    verdict: Verdict = ACCEPTED
    placement: Placement | None = None  # of the CAD model relative to the path

    @staticmethod
    def of(
        rounds: Sequence[RoundResult],
        estimate: Estimate,
        verdict: Verdict = ACCEPTED,
        placement: Placement | None = None,
    ) -> Phase:
        """Make a phase from its rounds, in their order. There may be none.

        estimate: what the phase found, from which the next phase starts.
        """
        first, last = (rounds[0], rounds[-1]) if rounds else (None, None)
        return Phase(
            history=tuple(done.history for done in rounds),
            start=None if first is None else first.start,
            first=first,
            last=last,
            estimate=estimate,
            verdict=verdict,
            placement=placement,
        )

    def then(self, later: Phase | None) -> Phase:
        """Join this phase with a later one that continues from it. None: return this phase.

        The later one decides whether it is accepted. What the verdicts found is kept from both, and
        that of the later one goes first.
        """
        if later is None:
            return self
        here, there = self.verdict, later.verdict
        conflict = there.length_conflict
        return Phase(
            history=(*self.history, *later.history),
            start=self.start or later.start,
            first=self.first or later.first,
            last=later.last or self.last,
            estimate=later.estimate,
            verdict=Verdict(
                accepted=there.accepted,
                reason=there.reason,
                stereo=there.stereo or here.stereo,
                length_conflict=here.length_conflict if conflict is None else conflict,
                suspects=there.suspects or here.suspects,
            ),
            placement=later.placement,
        )


@dataclass(frozen=True, kw_only=True)
class RoundSolver:
    """Solve rounds, and keep and report their history."""

    calibrated: Rig  # with the calibrated intrinsics, which are the mean of their prior
    options: AdjustOptions
    strategy: Strategy
    report: Report  # called with a line of text after each round
    anchors: int = ANCHORS  # landmarks of the rounds before the last, about
    history: list[iteration_history.Round] = field(default_factory=list)  # of all rounds so far
    begun_s: float = field(default_factory=time.perf_counter)  # start of the adjustment
    keep: Keep = make_anew  # loads the phases that an interrupted run has finished

    def once(self, solve: Callable[[], Phase], label: str) -> Phase:
        """Solve a phase, or load it where an interrupted run has finished it.

        label: the name under which it is kept. The history of rounds is restored with the phase.
        """
        phase, rounds = self.keep(lambda: (solve(), tuple(self.history)), label)
        self.history[:] = rounds
        return phase

    @property
    def settings(self) -> native.Options:
        """The solver's options, but for the iterations and tolerance that each solve sets."""
        return self.strategy.native_options(self.options)

    def coarse_rounds(self, start: Estimate, count: int) -> tuple[RoundResult, ...]:
        """Solve rounds on some well-seen landmarks, each from the previous round."""
        rounds: list[RoundResult] = []
        for _ in range(count):
            rounds.append(self.solve_round(rounds[-1].after if rounds else start))
        return tuple(rounds)

    def solve_round(
        self, before: Estimate, *, final: bool = False, hold_hull_pose: bool = False
    ) -> RoundResult:
        """Solve one round from an estimate.

        Parameters
        ----------
        before
            The estimate to start from.
        final
            Solve all landmarks instead of some well-seen ones, to the finer tolerance.
        hold_hull_pose
            Hold the hull's pose where it is.

        Raises
        ------
        StageError
            When too few landmarks agree with the navigation.
        """
        # Triangulate landmarks from the path, and choose the measurements that agree with it.
        measured = before.measured
        state, chosen = selection.find_landmarks(
            measured, before.state, _outlier_limit(before, final)
        )
        chosen = self._choose(measured, state, chosen, final)
        surface = weighting.surface_weights(state, chosen, self.strategy)
        weights = replace(before.weights, surface=surface)

        # Assemble and solve. Each round starts from the calibrated intrinsics.
        problem = assemble(
            measured, state, weights, chosen, self.strategy.systematic_errors, hold_hull_pose
        )
        problem = intrinsics.free_intrinsics(problem, self.calibrated, self.options)
        problem = lens.free_lenses(problem, measured, weights.lens)
        began_s = time.perf_counter() - self.begun_s
        plan = self._plan(problem, state)
        return_free_memory()  # the solver's tables come on top of what the allocator keeps
        result = self._solve(problem, plan, final)
        history = self._record(measured, result, weights, chosen, began_s)

        # Sigmas and outlier limit of the next round follow from the residuals.
        state = state_from_unknowns(state, result.unknowns, chosen)
        measured = intrinsics.apply_intrinsics(measured, problem, result)
        measured = lens.apply_lenses(measured, problem, result)
        found = weights
        if not final:
            found = weighting.estimate_weights(measured, state, chosen, weights, self.strategy)
        self.report(_describe_round(len(self.history), result, chosen, found))
        return RoundResult(
            chosen=chosen,
            weights=weights,
            plan=plan,
            start=problem,
            problem=problem.started_from(result.unknowns),
            result=result,
            history=history,
            after=Estimate(
                measured=measured,
                state=state,
                weights=found,
                max_px=OUTLIER_SIGMAS * found.pixel,
            ),
        )

    def _choose(
        self, measured: Measurements, state: State, chosen: Selection, final: bool
    ) -> Selection:
        """Choose the landmarks of a round: anchors for a coarse one, nearly all for the last.

        The last round leaves out landmarks off the hull with few rays and few neighbours. A
        strategy may leave out those that are far off the hull. Raises StageError with fewer than
        MIN_LANDMARKS.

        state, chosen: triangulated landmarks, and the measurements that agree with them.
        """
        settings, strategy = self.settings, self.strategy
        if final and state.hull is not None and strategy.deviation_field:
            off = np.abs(state.hull.deviation(state.landmark[chosen.landmarks]))
            # distance from which a landmark is labelled as off the hull
            boundary = selection.label_boundary(settings.sigma_on, settings.sigma_off)
            chosen = selection.drop_isolated_landmarks(state, chosen, off > boundary)
        if np.isfinite(strategy.max_off_hull_m) and state.hull is not None:
            off = np.abs(state.hull.deviation(state.landmark[chosen.landmarks]))
            chosen = replace(chosen, landmarks=chosen.landmarks[~(off > strategy.max_off_hull_m)])
        if not final:
            chosen = selection.choose_anchors(measured, chosen, self.anchors)
        if measured.tracks is not None and len(chosen.landmarks) < MIN_LANDMARKS:
            raise StageError(
                f"only {len(chosen.landmarks)} landmarks agree with the navigation",
                remedy=DVL_ALONE,
            )
        return chosen

    def _plan(self, problem: native.Problem, state: State) -> Plan:
        """Plan the parts of a round. A coarse one is whole up to some 7,000 nodes."""
        if self.strategy.solve is not native.solve:
            return whole(problem, "this variant of the method is solved whole")
        plan = plan_parts(problem, state, self.options.parts)
        if plan.parts > 1:
            self.report(f"solving in {plan.parts} parts: {plan.reason}")
        return plan

    def _solve(self, problem: native.Problem, plan: Plan, final: bool) -> native.Result:
        """Solve a problem in the parts of the plan. final: to the finer tolerance."""
        settings = replace(
            self.settings,
            max_iterations=self.options.max_iterations,
            function_tolerance=FUNCTION_TOLERANCE if final else COARSE_TOLERANCE,
            initial_radius=INITIAL_RADIUS,
        )
        if plan.parts > 1:
            return join.solve(problem, plan, settings)
        return self.strategy.solve(problem, settings)

    def _record(
        self,
        measured: Measurements,
        result: native.Result,
        weights: Weights,
        chosen: Selection,
        began_s: float,
    ) -> iteration_history.Round:
        """Record a solve: add it to the history, and its table to the log (`--verbose`).

        began_s: start of the solve, seconds since the start of the adjustment.
        """
        done = iteration_history.Round(
            record=result.iterations,
            pixel_sigma_px=weights.pixel,
            tray_sigma_rad=weights.tray,
            range_sigma_m=weights.range_sigma,
            depth_sigma_m=weighting.depth_sigma(measured, weights),
            landmarks=len(chosen.landmarks),
            converged=result.converged,
            message=result.message,
            began_s=began_s,
        )
        self.history.append(done)
        for line in iteration_history.lines(len(self.history), done):
            log.debug("%s", line)
        return done


def _outlier_limit(before: Estimate, final: bool) -> Callable[[Array], Array]:
    """Make the threshold (m,) px of reprojection errors, by the detector's response (m,).

    A feature with a weak response is located less well, and its threshold is larger.
    """

    def limit_px(response: Array) -> Array:
        max_px = before.max_px * before.weights.by_response.ratio(response)
        return max_px if final else np.maximum(LEAST_MAX_PX, max_px)

    return limit_px


def _describe_round(number: int, result: native.Result, chosen: Selection, weights: Weights) -> str:
    """Write the line of a round for the log. weights: those for the next round."""
    record = result.iterations
    cost = reached_cost(record.cost, record.accepted)
    return (
        f"round {number}: {len(record.cost) - 1} iterations, cost {cost[0]:.6g} to {cost[-1]:.6g}, "
        f"{len(chosen.landmarks)} landmarks, {int((result.label == 1).sum())} on the hull, "
        f"pixel sigma now {weights.pixel:.2f}"
    )
