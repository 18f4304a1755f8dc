"""An episode in the terminal, event by event: styled on a terminal, plain text elsewhere."""

from collections.abc import Callable, Sequence
from typing import Final

from rich.console import Console
from rich.padding import Padding
from rich.status import Status
from rich.text import Text

from surefetch.common.messages import (
    Accepted,
    Acted,
    Acting,
    Believed,
    Captured,
    Decided,
    Ended,
    Equipped,
    Event,
    Happening,
    Perceived,
)
from surefetch.evaluation.showing import words

TOP: Final = 5
"""Hypotheses shown after a step."""
BAR_CELLS: Final = 28
EIGHTHS: Final = " ▏▎▍▌▋▊▉"
OUTCOME_STYLES: Final = {"grasped": "bold green", "deferred": "bold yellow"}


def bar(share: float, cells: int = BAR_CELLS) -> str:
    """A bar of this share of the cells, to an eighth of a cell."""
    eighths = round(max(0.0, min(1.0, share)) * cells * 8)
    partial = EIGHTHS[eighths % 8].strip()
    return ("█" * (eighths // 8) + partial).ljust(cells)


class Progress:
    """Prints what happens. On a terminal, a spinner tells what is being waited for."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._waiting: Status | None = None
        self._expected_q = ""
        self._seen: Text | None = None
        """What a look showed, until it is known under which condition it was taken."""
        self._reason = ""
        self._seen_step = -1
        self._believed_step = -1

    def show(self, event: Event) -> None:
        """Print one event."""
        self._print(self._lines(event.happening, event.step))
        self.wait(_next(event.happening))

    def ended(self, ended: Ended) -> None:
        """Print how the episode ended."""
        self._print([*self._header(ended), *self._ended(ended, 0)])

    def say(self, text: str, style: str = "") -> None:
        """Print a line that is no event."""
        self.wait(None)
        self._console.print(Text(text, style=style), soft_wrap=True)

    def wait(self, text: str | None) -> None:
        """Say what is being waited for, on a terminal only; None ends it."""
        if self._waiting is not None:
            self._waiting.stop()
            self._waiting = None
        if text is not None and self._console.is_terminal:
            self._waiting = self._console.status(Text(text, style="dim"))
            self._waiting.start()

    def _print(self, lines: Sequence[Text]) -> None:
        """Lines one by one; on a terminal, long ones go on below their own beginning."""
        self.wait(None)
        for line in lines:
            indent = len(line.plain) - len(line.plain.lstrip())
            if self._console.is_terminal and indent:
                self._console.print(Padding(line[indent:], (0, 0, 0, indent), expand=False))
            else:
                self._console.print(line, soft_wrap=True)

    def close(self) -> None:
        """End the spinner, so that the terminal is as it was."""
        self.wait(None)

    def _lines(self, happening: Happening, step: int) -> list[Text]:
        writers: dict[type, Callable[..., list[Text]]] = {
            Accepted: _accepted,
            Equipped: _equipped,
            Captured: self._captured,
            Perceived: self._perceived,
            Believed: self._believed,
            Decided: self._decided,
            Acted: _acted,
            Ended: self._ended,
        }
        writer = writers.get(type(happening))
        header = self._header(happening)
        return header if writer is None else [*header, *writer(happening, step)]

    def _header(self, happening: Happening) -> list[Text]:
        """The beginning of a step that is due, with its viewing condition as far as it is known."""
        if self._seen is None:
            return []
        q = happening.q if isinstance(happening, Believed) else self._expected_q
        seen, self._seen = self._seen, None
        return [Text(), Text.assemble((f"step {self._seen_step}  {q}", "bold cyan"), seen)]

    def _captured(self, captured: Captured, _: int) -> list[Text]:
        self._expected_q = captured.q
        return []

    def _perceived(self, perceived: Perceived, step: int) -> list[Text]:
        container = f"container {perceived.cover}" if perceived.container else "no container seen"
        found = f"  {perceived.n_candidates} candidates, {container}"
        took = (f"  ({perceived.duration_s:.2f} s)", "dim")
        if step == self._believed_step:
            return [Text.assemble(f"    seen after it:{found}", took)]
        self._seen, self._seen_step = Text.assemble(found, took), step
        return []

    def _believed(self, believed: Believed, step: int) -> list[Text]:
        self._believed_step = step
        return _hypotheses(believed)

    def _decided(self, decided: Decided, _: int) -> list[Text]:
        self._reason = decided.because
        costs = ", ".join(words.q_value(value) for value in decided.q_values)
        lines = [
            Text.assemble(
                "  → ", (words.choice(decided.choice), "bold"), (f"   Q: {costs}", "dim")
            ),
            Text(f"    {decided.because}", style="italic"),
        ]
        refused = [v for v in decided.feasibility.grasps if not v.feasible]
        lines += [
            Text(f"    T{v.track} cannot be grasped: {v.refusal}: {v.why}", style="yellow")
            for v in refused
        ]
        return lines

    def _ended(self, ended: Ended, _: int) -> list[Text]:
        """The outcome, and why, unless that was said with the last decision."""
        style = OUTCOME_STYLES.get(ended.outcome, "bold red")
        what = "" if ended.track is None else f" T{ended.track} ({ended.relation})"
        delivered = {True: ", delivered", False: ", not delivered", None: ""}[ended.delivered]
        why = [] if ended.because == self._reason else [Text(f"  {ended.because}")]
        return [Text(), Text.assemble((ended.outcome, style), what + delivered), *why]


def _accepted(accepted: Accepted, _: int) -> list[Text]:
    return [Text.assemble(("understood  ", "dim"), (accepted.understood, "bold"))]


def _equipped(equipped: Equipped, _: int) -> list[Text]:
    rules = f"policy {equipped.policy}, profile {equipped.profile}"
    return [Text.assemble(("rules       ", "dim"), rules)]


def _hypotheses(believed: Believed) -> list[Text]:
    shown = words.ranked(believed.belief)[:TOP]
    width = max(len(words.hypothesis(name)) for name, _ in shown)
    lines = [_hypothesis_line(name, share, believed.gamma, width) for name, share in shown]
    members = ", ".join(words.hypothesis(name) for name in believed.gamma)
    return [*lines, Text.assemble("  Γ = {", (members or "nothing", "magenta"), "}")]


def _hypothesis_line(name: str, share: float, gamma: tuple[str, ...], width: int) -> Text:
    inside = name in gamma
    return Text.assemble(
        "  ",
        (words.hypothesis(name).ljust(width), "bold" if inside else ""),
        "  ",
        (bar(share), "magenta" if inside else "blue"),
        f" {share:6.3f}",
        (" ∈ Γ" if inside else "", "magenta"),
    )


def _acted(acted: Acted, _: int) -> list[Text]:
    style = "green" if acted.status == "done" else "red"
    why = "" if acted.status == "done" or not acted.why else f": {acted.why}"
    return [
        Text.assemble(
            f"    {acted.action} ",
            (acted.status, style),
            why,
            (f"  ({acted.duration_s:.1f} s of motion)", "dim"),
        )
    ]


def _next(happening: Happening) -> str | None:
    """What the terminal waits for after an event."""
    if isinstance(happening, Acting):
        return f"{words.verb(happening.verb)} …"
    after = {
        Accepted: "looking …",
        Captured: "perceiving …",
        Perceived: "updating the belief …",
        Believed: "planning …",
        Acted: "looking …",
    }
    return after.get(type(happening))
