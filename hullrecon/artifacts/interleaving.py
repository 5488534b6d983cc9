# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Take several steps of a chain at a time, each in its process, from one thread of the run."""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Sequence
from multiprocessing.connection import wait
from typing import TypeAlias, TypeVar

from hullrecon.artifacts.stage import Stage
from hullrecon.artifacts.step_call import BegunStep, Made

Result = TypeVar("Result")
# Work on a step. It yields the step's function where that goes on in another process, and is
# resumed where that has said something.
Course: TypeAlias = Generator[BegunStep, None, Result]


def interleave(
    stages: Sequence[Stage],
    take: Callable[[Stage], Course[Result]],
    fit_together: Callable[[Collection[str]], bool],
) -> list[Result]:
    """Begin each stage as soon as what it takes is there, in order, if it fits to those under way.

    An error ends those under way, which keep what is finished.
    """
    done, courses = dict[str, Result](), dict[str, Course[Result]]()
    begun: dict[str, BegunStep] = {}
    try:
        while len(done) < len(stages):
            stage = _next_stage(stages, done, courses, fit_together)
            if stage is None:
                ready = wait([source for step in begun.values() for source in step.says])
                resumed = [name for name, step in begun.items() if {*step.says} & {*ready}]
            else:
                courses[stage.name] = take(stage)
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
    """Find the first stage of which nothing that it takes is to come, and that may begin now."""
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
    """Hear what a step says until it has ended. Where something else ends the run, end it too."""
    try:
        while (made := begun.hear()) is None:
            yield begun
    except BaseException:
        begun.interrupt()
        begun.end()
        raise
    return made


def run_to_end(course: Course[Result]) -> Result:
    """Take one step alone."""
    while True:
        try:
            wait(next(course).says)
        except StopIteration as end:
            result: Result = end.value
            return result
