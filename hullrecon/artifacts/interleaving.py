# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run several steps of a chain at the same time, each in its process, from one thread."""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Sequence
from multiprocessing.connection import wait
from typing import TypeAlias, TypeVar

from hullrecon.artifacts.stage import Stage
from hullrecon.artifacts.step_call import BegunStep, Made

Result = TypeVar("Result")
# Coroutine that brings one step up to date. It yields the step that is running in another process
# whenever it has to wait for it, and is resumed when that process has sent something.
Course: TypeAlias = Generator[BegunStep, None, Result]


def interleave(
    stages: Sequence[Stage],
    bring_up: Callable[[Stage], Course[Result]],
    fit_together: Callable[[Collection[str]], bool],
) -> list[Result]:
    """Run the stages, each as soon as its inputs are there, several at the same time if allowed.

    Of stages that are ready the first in order begins. An error ends those that are running, which
    keep their finished parts.

    Parameters
    ----------
    stages
        Each after its inputs.
    bring_up
        Makes the coroutine of a stage.
    fit_together
        Whether the stages of these names may run at the same time.

    Returns
    -------
    results
        What each coroutine returned, in the order of the stages.
    """
    # A stage's coroutine yields its process whenever it has to wait for that, and returns at the
    # end. `courses` are the coroutines under way, `begun` the processes that they wait for.
    done, courses = dict[str, Result](), dict[str, Course[Result]]()
    begun: dict[str, BegunStep] = {}
    try:
        while len(done) < len(stages):
            stage = _next_stage(stages, done, courses, fit_together)
            if stage is None:
                ready = wait([source for step in begun.values() for source in step.waitables])
                resumed = [name for name, step in begun.items() if {*step.waitables} & {*ready}]
            else:
                courses[stage.name] = bring_up(stage)
                resumed = [stage.name]
            for name in resumed:
                try:
                    begun[name] = next(courses[name])
                except StopIteration as end:
                    done[name] = end.value
                    del courses[name]
                    begun.pop(name, None)
    except BaseException:
        for step in begun.values():
            step.interrupt()
        for course in courses.values():
            course.close()
        raise
    return [done[stage.name] for stage in stages]


def _next_stage(
    stages: Sequence[Stage],
    done: Collection[str],
    under_way: Collection[str],
    fit_together: Callable[[Collection[str]], bool],
) -> Stage | None:
    """Find the first stage whose inputs are all done and that may run beside those under way.

    None if there is none: then wait for those under way.
    """
    to_come = {stage.name for stage in stages} - {*done}
    for stage in stages:
        if (
            stage.name in to_come
            and stage.name not in under_way
            and to_come.isdisjoint({*stage.inputs, *stage.optional})
            and (not under_way or fit_together([*under_way, stage.name]))
        ):
            return stage
    return None


def await_end(begun: BegunStep) -> Course[Made]:
    """Process the messages of a running step until it has ended, and return what it left.

    If the run ends for another reason meanwhile, the step is ended too.
    """
    try:
        while (made := begun.poll()) is None:
            yield begun
    except BaseException:
        begun.interrupt()
        begun.end()
        raise
    return made


def run_to_end(course: Course[Result]) -> Result:
    """Run the coroutine of a single step to its end."""
    while True:
        try:
            wait(next(course).waitables)
        except StopIteration as end:
            result: Result = end.value
            return result
