"""One HTML page that shows figures, pictures and videos that lie beside it."""

import html
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from adapt_envs.drawing.palette import INK, PAPER, RULE, RULE_STRONG, SHADE, css
from sb3_adaptnet.evaluation.figures import Figures

ROWS = (
    ("goal reward", "goal_reward", "{:.3f}"),
    ("falls per minute", "falls_per_minute", "{:.2f}"),
    ("... of them lost targets", "lost_per_minute", "{:.2f}"),
    ("targets reached", "targets_reached", "{:.0%}"),
    ("imitation error [m]", "imitation_error_m", "{:.3f}"),
    ("... its standard deviation [m]", "imitation_error_std_m", "{:.3f}"),
    ("... at about the clip's tempo [m]", "tempo_error_m", "{:.3f}"),
    ("... of the base [m]", "base_tempo_error_m", "{:.3f}"),
    ("... in world space [m]", "world_error_m", "{:.3f}"),
    ("speed straight ahead [m/s]", "speed_m_s", "{:.2f}"),
    ("... that was asked for [m/s]", "asked_speed_m_s", "{:.2f}"),
    ("cadence [Hz]", "cadence_hz", "{:.2f}"),
    ("... of the clip [Hz]", "clip_cadence_hz", "{:.2f}"),
    ("foot height [m]", "foot_height_m", "{:.2f}"),
    ("... of the clip [m]", "clip_foot_height_m", "{:.2f}"),
    ("flight share", "flight_share", "{:.0%}"),
    ("... of the clip", "clip_flight_share", "{:.0%}"),
    ("style visible", "visible", ""),
    ("foot slip, median [cm/s]", "slip_median_cm_s", "{:.1f}"),
    ("foot slip, 90th percentile [cm/s]", "slip_p90_cm_s", "{:.1f}"),
    ("jerk over the clip's", "jerk_ratio", "{:.2f}"),
    ("simulated seconds", "seconds", "{:.0f}"),
)
"""Words, field and format of every figure in a table."""
_STYLE = f"""
body {{ font: 16px/1.55 system-ui, sans-serif; color: {css(INK)}; background: {css(PAPER)}; margin: 2.5rem auto;
       max-width: 1180px; padding: 0 1.5rem; }}
h1 {{ font-size: 1.7rem; margin-bottom: .3rem; }} h2 {{ font-size: 1.2rem; margin-top: 2.2rem; }}
img, video {{ max-width: 100%; border: 1px solid {css(RULE)}; border-radius: 6px; display: block; margin: .6rem 0; }}
table {{ border-collapse: collapse; margin: 1rem 0; }} th, td {{ padding: .35rem 1rem; text-align: right; }}
th:first-child, td:first-child {{ text-align: left; }} tr {{ border-bottom: 1px solid {css(RULE)}; }}
thead {{ border-bottom: 2px solid {css(RULE_STRONG)}; }} p {{ max-width: 48rem; }}
pre {{ background: {css(SHADE)}; border-radius: 4px; padding: .8rem 1rem; overflow-x: auto; }}
"""


def cells(figures: Mapping[str, Figures]) -> list[list[str]]:
    """The table's body: one row per figure, its words first, then one text per column; "-" where there is none."""
    values = [figure.as_dict() for figure in figures.values()]
    return [[words, *(text_of(column[name], text) for column in values)] for words, name, text in ROWS]


def text_of(value: Any, text: str) -> str:
    """A figure in words: a format for numbers, "-" where there is none."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "-" if value is None else text.format(value)


def text_table(figures: Mapping[str, Figures]) -> str:
    """Figures by column as lines of text, and below them why styles are not visible."""
    rows = [["", *figures], *cells(figures)]
    first = max(len(row[0]) for row in rows)
    widths = [max(len(row[i]) for row in rows) + 2 for i in range(1, len(rows[0]))]
    lines = (row[0].ljust(first) + "".join(c.rjust(w) for c, w in zip(row[1:], widths, strict=True)) for row in rows)
    return "\n".join([*(line.rstrip() for line in lines), *complaints(figures)])


def complaints(figures: Mapping[str, Figures]) -> list[str]:
    """Why styles are not visible, a line each."""
    return [f"{name} is not visible: {test}" for name, found in figures.items() for test in found.failed_tests]


def table(figures: Mapping[str, Figures]) -> str:
    """Figures by column as an HTML table."""
    head = "".join(f"<th>{html.escape(name)}</th>" for name in ("", *figures))
    body = "".join("<tr>" + "".join(f"<td>{html.escape(c)}</td>" for c in row) + "</tr>\n" for row in cells(figures))
    return f"<table><thead><tr>{head}</tr></thead>\n<tbody>{body}</tbody></table>"


def paragraph(text: str) -> str:
    """A paragraph of plain text."""
    return f"<p>{html.escape(text)}</p>"


def listing(text: str) -> str:
    """Lines of code."""
    return f"<pre>{html.escape(text)}</pre>"


def link(address: str, words: str) -> str:
    """A paragraph that is a link."""
    return f'<p><a href="{html.escape(address)}">{html.escape(words)}</a></p>'


def picture(file: str, words: str) -> str:
    """A picture that lies beside the page."""
    return f'<img src="{html.escape(file)}" alt="{html.escape(words)}">'


def video(file: str) -> str:
    """A video that lies beside the page."""
    return f'<video src="{html.escape(file)}" controls loop autoplay muted playsinline></video>'


def write_page(path: Path, title: str, sections: Sequence[tuple[str, Sequence[str]]]) -> None:
    """Write a page.

    Args:
        path: the `.html` file.
        title: its title, plain text.
        sections: (heading, parts), the parts made by this module's functions; an empty heading for the introduction.
    """
    parts = []
    for heading, blocks in sections:
        parts += [f"<h2>{html.escape(heading)}</h2>"] if heading else []
        parts += blocks
    body = "\n".join(parts)
    path.write_text(
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<style>{_STYLE}</style></head>\n'
        f"<body><h1>{html.escape(title)}</h1>\n{body}\n</body></html>\n",
        encoding="utf-8",
    )
