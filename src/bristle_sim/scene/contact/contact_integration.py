"""Integration of one contact in time: smooth intervals of compression, restitution, slip and stick, up to what ends each."""

from __future__ import annotations

from functools import partial

from bristle_sim.scene.contact.contact_course import ContactCourse, CourseMark
from bristle_sim.scene.contact.contact_motion import ContactMotion, Saved, Turn

SAME = 1e-5
"""Slip and compression of one degree of freedom stop together: with less than this fraction of the approach left."""

PATIENCE = 10.0
"""A contact that lasts this many times longer than an impact of its speed would is no impact: something presses the
point on. It ends as ``no rebound``, in sustained contact; or where the rigid-body law ends, in a jam or in stiction. On a
wire that vibrates it lasts until the spring lets go: a closed contact would be another one."""

SHORTEST_CONTACT_INTERVAL = 1e-9
"""Intervals shorter than this fraction of a contact mean that none is short enough: rounding exceeds the tolerance."""

MOST_INTERVALS = 1000
"""A contact that takes more intervals than this is given up; that of a wire that vibrates once its steps are spent."""

OUT_OF_STEPS = "contact: step budget spent before it is over; must have more steps, a larger accuracy or a shorter contact_duration"
ENDLESS = (
    "contact: not over after {} intervals of its motion; friction must be further from the jam, or links' masses closer to"
    " each other"
)
TOO_ACCURATE = (
    "contact: no interval of its motion is short enough for the requested accuracy; accuracy must be larger, or friction"
    " further from the jam"
)


class ContactIntegration:
    """Integration of one contact.

    Attributes:
        motion: what is integrated.
        expected: what is known of the contact beforehand.
        outcome: how the contact ended; None while it lasts.
        course: what is recorded.
    """

    def __init__(self, motion: ContactMotion) -> None:
        """Begin at the first touch."""
        self.motion = motion
        self.expected = motion.expected
        self.outcome: str | None = None
        self.course = ContactCourse()
        self._stop: tuple[Saved, CourseMark] | None = None
        if not motion.spring.slip:
            self._settle()
        self._note_phase()
        self._sample()

    def run(self, last: int) -> str:
        """Integrate until the contact is over, up to so much of the scene's ``work``, and return the outcome.

        Raises:
            ValueError: if the contact comes to no end.
        """
        try:
            self._run(last)
        except ValueError:
            if self._stop is None:
                raise
        if self._stop is not None and self.outcome != "rebound":
            self._end_at(*self._stop)
        return self.outcome or self.expected.outcome

    def _run(self, last: int) -> None:
        most = max(MOST_INTERVALS, int(4 * self.expected.duration / self.motion.stepper.propose(self.expected.longest)))
        if self.expected.vibrates:
            most = max(most, last - self.motion.scene.work)
        for _ in range(most):
            if self.outcome:
                return
            if self.motion.scene.work > last:
                raise ValueError(OUT_OF_STEPS)
            self._interval()
        raise ValueError(ENDLESS.format(most))

    def _interval(self) -> None:
        """Integrate one interval, up to what first ends the smooth motion."""
        length = self.motion.stepper.propose(self.expected.longest)
        self.motion.follow_bodies()
        result = self.motion.advance(length)
        if not self.motion.stepper.accepts(result, length):
            if length < SHORTEST_CONTACT_INTERVAL * self.expected.duration:
                raise ValueError(TOO_ACCURATE)
            return
        result, act = self.motion.up_to_first(result, length, self._turns())
        self.motion.state = result.state
        self.course.add(result.totals[:4])
        self.motion.stick_force = result.totals[5]
        if act is not None:
            self._sample()
            act()
            if self.outcome is None and not self.expected.vibrates and self.motion.opened():
                self.outcome = "rebound"
            self._note_phase()
        self._sample()
        lasts = self.motion.state.time - self.course.begin > PATIENCE * self.expected.duration
        if self.outcome is None and lasts and not self.expected.vibrates:
            self.outcome = "no rebound"

    def _turns(self) -> list[Turn]:
        """Return what can end the smooth motion that the contact is in."""
        spring, motion = self.motion.spring, self.motion
        if spring.loading:
            turns = [Turn(lambda at: motion.velocity(at.state)[0], True, self._end_compression)]
        else:
            rebound, duration = partial(setattr, self, "outcome", "rebound"), self.expected.duration
            turns = [
                Turn(lambda at: motion.penetration(at.state) - spring.residual, False, rebound, duration),
                Turn(lambda at: motion.penetration(at.state) - spring.peak, True, self._reload, duration),
            ]
        if spring.slip:
            turns.append(Turn(lambda at: spring.slip * motion.velocity(at.state)[1], False, self._settle))
        elif spring.tangential:
            turns.append(Turn(motion.spare, False, motion.break_away, spring.stiffness * self.expected.duration))
        return turns

    def _end_compression(self) -> None:
        """Begin unloading, and settle slip that has stopped; without restitution the contact is over."""
        self.course.end_compression()
        spring = self.motion.spring
        spring.unload(self.motion.tip)
        if spring.coefficients.restitution == 0.0:
            self.outcome = "no rebound"
            return
        if self.expected.outcome == "stiction":
            self._stopped()
        if not spring.slip and self.outcome is None:
            self._settle()

    def _reload(self) -> None:
        """Compress further than before: the spring has been pressed back past its peak."""
        self.motion.spring.loading = True
        if not self.motion.spring.slip:
            self._settle()

    def _settle(self) -> None:
        """Let the point stick or slip on where slip has stopped, or end the compression that stops with it."""
        spring = self.motion.spring
        self.motion.stop_slip()
        if not (spring.loading and self.course.rows):
            return
        stopped = self.expected.outcome == "stiction" and not spring.slip
        # Slip and compression of one degree of freedom stop together, up to the motion during the contact.
        approach = -self.motion.velocity(self.motion.state)[0]
        if (stopped and not self.expected.resumes) or approach <= SAME * self.course.approach:
            self._end_compression()
        elif stopped:
            self._stopped()

    def _note_phase(self) -> None:
        """Record the phase that begins; where the rigid-body law jams, stick in compression ends it."""
        if self.outcome is not None:
            return
        spring = self.motion.spring
        self.course.begin_phase(spring.loading, spring.slip)
        if self.expected.outcome == "jam" and spring.loading and not spring.slip:
            self._stopped()

    def _stopped(self) -> None:
        """Note that the rigid-body law ends here without rebound; a contact of a given duration may still find its way out."""
        if not self.expected.resumes:
            self.outcome = self.expected.outcome
        elif self._stop is None:
            self._stop = self.motion.saved(), self.course.mark()

    def _end_at(self, saved: Saved, mark: CourseMark) -> None:
        """End where the rigid-body law does: the contact comes to no end of its own either."""
        self.outcome = self.expected.outcome
        self.motion.restore(saved)
        self.course.return_to(mark)
        self._sample()

    def _sample(self) -> None:
        """Record the state that was reached."""
        self.course.rows.append(self.motion.sample(touches=self.outcome != "rebound"))
        self.course.states.append(self.motion.state)
