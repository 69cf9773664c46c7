"""Writes docs/internals/mutation-scores.md: `python -m benchmarks.mutation_table [FILE.json…]`.

Takes the cases in each FILE, which `shaderlab mutate --json FILE` wrote, into mutation-scores.json,
and writes the page's tables from that. Survivors that nothing in mutation-survivors.toml is about,
which says why mutants survive, are printed, and the exit status is 1. Of files that `mutate --api`
wrote, the cases go to api-mutation-scores.json, and their survivors into the table.
"""

from __future__ import annotations

import json
import re
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

REPOSITORY = Path(__file__).resolve().parents[1]
FOLDER = REPOSITORY / "docs" / "internals"
PAGE = FOLDER / "mutation-scores.md"
SCORES = FOLDER / "mutation-scores.json"
SURVIVORS = FOLDER / "mutation-survivors.toml"
API_SCORES = FOLDER / "api-mutation-scores.json"
_KILLED, _SURVIVED, _UNREAD = "killed", "survived", "unread"
_STATE_KILLED, _STATE_SURVIVED = "killed in state", "survived in state"

Row = dict[str, int]
Entry = Mapping[str, Any]


def main(files: Sequence[str]) -> int:
    """Write the page and return the exit status."""
    scores, calls, known = load_scores(), load_api_scores(), load_survivors()
    unknown = []
    for file in files:
        data = json.loads(Path(file).read_text(encoding="utf-8"))
        if data.get("api"):
            calls |= {case["id"]: api_row_of(case, int(data["seed"])) for case in data["cases"]}
            continue
        for case in data["cases"]:
            scores[case["id"]] = row_of(case, int(data["limit"]), int(data["seed"]))
            unknown += [
                "{id}: {file}:{line}  {operator}: {before} → {after}".format(id=case["id"], **s)
                for s in case["survived"]
                if not any(is_about(entry, case["id"], s) for entry in known)
            ]
    _write(SCORES, scores)
    _write(API_SCORES, calls)
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8"), scores, calls), encoding="utf-8")
    for line in unknown:
        print(f"not in {SURVIVORS.name}: {line}")
    return 1 if unknown else 0


def load_scores() -> dict[str, Row]:
    """Each case's counts, by id."""
    scores: dict[str, Row] = json.loads(SCORES.read_text(encoding="utf-8"))
    return scores


def load_api_scores() -> dict[str, Entry]:
    """What became of each case's mistakes in calls, by id."""
    scores: dict[str, Entry] = json.loads(API_SCORES.read_text(encoding="utf-8"))
    return scores


def load_survivors() -> list[Entry]:
    """The explanations."""
    entries: list[Entry] = tomllib.loads(SURVIVORS.read_text(encoding="utf-8"))["survivor"]
    return entries


def row_of(case: Mapping[str, Any], limit: int, seed: int) -> Row:
    """A case's counts from what `mutate` says of it; state apart, where it has any."""
    survived, killed = case["survived"], case["killed_in_state"]
    of_state = sum(s["operator"] == "state" for s in survived)
    row = {_KILLED: case["killed"] - killed, _SURVIVED: len(survived) - of_state}
    row[_UNREAD] = sum(s.get("unread", False) for s in survived)
    if killed or of_state:
        row |= {_STATE_KILLED: killed, _STATE_SURVIVED: of_state}
    others = case["equivalent"] + len(case["no_difference"]) + case["invalid"]
    if limit and case["killed"] + len(survived) + others == limit:
        row |= {"sample": limit, "seed": seed}
    return row


def api_row_of(case: Mapping[str, Any], seed: int) -> Entry:
    """A case's counts from what `mutate --api` says of it, and what survived."""
    return {
        _KILLED: case["killed"],
        _SURVIVED: [f"{s['before']} → {s['after']}" for s in case["survived"]],
        "equivalent": case["equivalent"],
        "no difference": len(case["no_difference"]),
        "seed": seed,
    }


def is_about(entry: Entry, case_id: str, survivor: Mapping[str, Any]) -> bool:
    """Whether an explanation is about a survivor of a case."""
    if case_id not in entry.get("cases", (case_id,)):
        return False
    if survivor["operator"] not in entry.get("operators", (survivor["operator"],)):
        return False
    if survivor["operator"] == "state":
        change = f"{survivor['before']} → {survivor['after']}"
        return change.endswith(tuple(entry.get("state", ())))
    name, number = Path(survivor["file"]).name, int(survivor["line"])
    return (
        any(name == file and number == line_number(file, text) for file, text in lines_of(entry))
        or name in entry.get("files", ())
        or survivor["before"].startswith(tuple(entry.get("before", ())))
    )


def page(text: str, scores: Mapping[str, Row], calls: Mapping[str, Entry]) -> str:
    """The page with its tables made anew."""
    return between(between(text, "scores", score_table(scores)), "calls", call_table(calls))


def score_table(scores: Mapping[str, Row]) -> str:
    """The cases with survivors and how many, the others, the sums, and what was sampled."""
    missed = {case: row for case, row in scores.items() if _survivors(row)}
    shares = []
    for case, row in missed.items():
        shaders = f"{row[_SURVIVED]}/{row[_KILLED] + row[_SURVIVED]}"
        state, planted = row.get(_STATE_SURVIVED, 0), _planted_in_state(row)
        shares.append(f"{case} {shaders}{f' ({state}/{planted})' if planted else ''}")
    lines = [f"Not noticed, of the mutants of shaders (of state): {', '.join(shares)}."]
    names = (_KILLED, _SURVIVED, _STATE_KILLED, _STATE_SURVIVED, _UNREAD)
    total = {name: sum(row.get(name, 0) for row in scores.values()) for name in names}
    shaders = _share(total[_KILLED], total[_SURVIVED])
    state = _share(total[_STATE_KILLED], total[_STATE_SURVIVED])
    lines += ["", f"Noticed in all {len(scores)} cases: {shaders} in shaders, {state} in state."]
    lines.append(f"Of the survivors, {total[_UNREAD]} change only what no expectation reads.")
    samples = Counter((r["sample"], r["seed"]) for r in scores.values() if "seed" in r)
    limits = ", ".join(f"{count} × `--limit {n} --seed {s}`" for (n, s), count in samples.items())
    return "\n".join([*lines, f"Samples of a case: {limits}."] if limits else lines)


def _survivors(row: Row) -> int:
    return row[_SURVIVED] + row.get(_STATE_SURVIVED, 0)


def _planted_in_state(row: Row) -> int:
    return row.get(_STATE_KILLED, 0) + row.get(_STATE_SURVIVED, 0)


def call_table(scores: Mapping[str, Entry]) -> str:
    """How many mistakes in calls are noticed; those that are not, with their cases."""
    noticed = sum(row[_KILLED] for row in scores.values())
    missed: dict[tuple[str, str], Counter[str]] = {}
    for case, row in scores.items():
        for change in row[_SURVIVED]:
            before, _, after = change.rpartition(" → ")
            call = (re.findall(r"\bgl\w+(?=\()", before) or [before])[0]
            missed.setdefault((call, after), Counter())[case] += 1
    count = sum(found.total() for found in missed.values())
    lines = [
        f"Noticed in {len(scores)} cases: {_share(noticed, count)}. Not noticed:",
        "",
        "| call | mistake | in |",
        "|---|---|---|",
    ]
    for (call, after), found in missed.items():
        cases = ", ".join(f"{case} ({n})" if n > 1 else case for case, n in found.items())
        lines.append(f"| `{call}` | `{after}` | {cases} |")
    return "\n".join(lines)


def line_number(file: str, text: str) -> int:
    """Where a shader has this line.

    Raises:
        LookupError: there is no such shader or line; the explanation is out of date.
    """
    for path in (REPOSITORY / "shaders").rglob(file):
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if line.strip() == text:
                return number
    raise LookupError(f"{SURVIVORS.name}: no shader {file} has the line {text!r}")


def _write(file: Path, scores: Mapping[str, Entry]) -> None:
    lines = (
        f"  {json.dumps(case)}: {json.dumps(row, ensure_ascii=False)}"
        for case, row in scores.items()
    )
    file.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def lines_of(entry: Entry) -> Iterator[tuple[str, str]]:
    """The shaders' lines that an explanation is about: file and text."""
    yield from entry.get("lines", ())


def _share(killed: int, survived: int) -> str:
    share = 100 * killed / max(killed + survived, 1)
    return f"{share:.1f} % of {killed + survived} mistakes"


def between(text: str, name: str, table: str) -> str:
    """The text with a table between its marks."""
    begin, end = f"<!-- {name}: generated -->", f"<!-- end of {name} -->"
    head, rest = text.split(begin)
    return f"{head}{begin}\n\n{table}\n\n{end}{rest.split(end)[1]}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
