"""How a stage stands just now."""

from __future__ import annotations

from typing import TYPE_CHECKING

from evastudio.live.status import Phase, Status

if TYPE_CHECKING:
    from evastudio.live.stage import Stage


def status_of(stage: Stage, now: float) -> Status:
    """What a person needs to know of `stage`; `now` is seconds of its clock."""
    act, review, recorder, clock = stage.act, stage.look_back, stage.recorder, stage.clock
    run, outcome, why = act.run, act.run.outcome, act.why()
    counting, decision = act.phase is Phase.COUNTDOWN, act.decision(clock.interval)
    return Status(
        phase=act.phase,
        mode=act.mode,
        countdown_s=max(0.0, act.countdown_ends - now) if counting else 0.0,
        pairs=recorder.pairs if recorder is not None else 0,
        seconds=run.steps * run.scene.dt_s,
        progress=float(run.scene.progress(run.after)[0]),
        outcome=outcome,
        success=None if outcome is None else outcome in run.scene.successes,
        can_undo=recorder is not None and recorder.can_undo,
        late_steps=clock.late_steps,
        steps=clock.steps,
        pace=clock.pace,
        position_s=None if review is None else review.seconds,
        length_s=run.reel.last * run.scene.dt_s,
        speed=0.0 if review is None else review.speed,
        take=None if review is None else run.reel.origin.take,
        drift_s=clock.drift_s,
        policy=act.actors.playing,
        others=None if act.actors.others is None else act.actors.others.name,
        familiarity=None if why is None else why.familiarity,
        silent=act.silent(why),
        forgotten=stage.rethought,
        by_hand=run.reel.steered(min(run.steps, run.reel.last - 1)),
        pushed=act.pushed,
        pushes=act.actors.pushes is not None,
        decision=decision,
        decides_s=None if decision is None else max(0.0, clock.due - now),
        lead=run.lead,
        camera=stage.camera,
        cameras=stage.cameras,
        seed=run.seed,
        forked=run.origin is not None,
        options=dict(run.scene.values),
        coach=stage.coach.advice,
        problem=None if recorder is None else recorder.problem,
    )
