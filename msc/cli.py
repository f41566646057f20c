"""The command line: `msc COMMAND …`.

A command is a function that takes the parsed arguments and one, `_add_…`, that declares
them; both stand together. Those of the book are the press's own, which is handed what
this package tells of itself. What takes seconds to load (the simulator, the search, the
study, the claims) is loaded by the faces `msc.search`, … when a command asks for it.
"""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import msc.claims
import msc.plots
import msc.robot
import msc.search
import msc.skills
import msc.study
import msc.worlds
from msc._cli_fit import FIT_COMMANDS
from msc._parallel import WorkersLost
from msc.data import (
    find_neighbors,
    find_table,
    find_world,
    load_dataset,
    read_package,
    read_result,
    save_table,
)
from msc.robot import Workspace
from press import (
    BOOK_COMMANDS,
    Commands,
    Subject,
    add_jobs,
    add_profile,
    add_seed,
    check_output,
    make_parser,
    page_titles,
    replace_file,
    run_command,
    tell_options,
    write_json,
)

_HEADLINE = "free", "obstacles"  # the two worlds of the book's first part


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : sequence of str, optional
        Command and options; those of the process by default.

    Returns
    -------
    int
        Exit status: 0; 2 after a bad argument, an unusable file, a killed worker or a
        failed chapter; 130 if interrupted.
    """
    try:
        return run_command(_parser(), arguments)
    except WorkersLost as error:
        print(f"msc: error: {error}; the same command begins anew", file=sys.stderr)
        return 2


def _parser() -> argparse.ArgumentParser:
    """Return the parser of all commands."""
    words = "Parameterized skills by manifold clustering."
    return make_parser("msc", words, COMMANDS, make_subject)


def make_subject(root: Path) -> Subject:
    """Return what the book is told of this package, and of the claims in a repository.

    Parameters
    ----------
    root : Path
        The repository.

    Returns
    -------
    Subject
        Numbers and verdicts that pages quote, tables of claims that they include, and
        the help of all commands.

    Raises
    ------
    ValueError
        If a claim or a result file is not as wanted.
    """
    commands = tell_options(_parser(), width=80)
    if not (root / msc.claims.CLAIMS).is_file():
        return Subject("msc", ("msc",), commands)
    values: dict[str, Any] = {}
    verdicts = []
    if (root / msc.claims.VERDICTS).is_file():
        verdicts = msc.claims.judge_all(root)
        values["verdicts"] = msc.claims.tally(msc.claims.summarise(verdicts))
    claims = msc.claims.load_claims(root / msc.claims.CLAIMS)
    values["n_claims"] = sum(claim.could_fail for claim in claims)
    studies = {
        world: root / "data/results" / f"study_{world}.json"
        for world in msc.claims.STUDIES
    }
    if all(path.is_file() for path in studies.values()):
        values |= msc.claims.headline_values(
            {name: read_result(path, root / "data") for name, path in studies.items()}
        )
    elsewhere = None
    if (over := root / msc.claims.OVER_WORLDS).is_file():
        found = json.loads(over.read_text("utf-8"))
        asked = msc.worlds.load_questions(root / "data/worlds/asked.yml")
        elsewhere = msc.claims.count_elsewhere(found, asked)
        values |= msc.claims.elsewhere_values(found)
    fragments = msc.claims.claim_fragments(verdicts, page_titles(root), elsewhere)
    return Subject("msc", ("msc",), commands, values, fragments)


def _add_options(parser: argparse.ArgumentParser) -> None:
    """Declare how options of the search are set."""
    parser.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="an option of the search, as max_evaluations=400; may be repeated",
    )


def _add_search(commands: Commands) -> None:
    """Declare `msc search`."""
    parser = commands.add_parser("search", help="search the policies of many tasks")
    _add_workspace(parser)
    parser.add_argument("--tasks", type=int, default=72, help="how many (72)")
    parser.add_argument("--offset", type=float, default=0.0, help="first angle (0)")
    parser.add_argument(
        "--skip", type=int, default=0, help="tasks of several numbers left out (0)"
    )
    parser.add_argument("--guide", type=Path, help="a table: neighbours to start from")
    add_seed(parser)
    add_jobs(parser)
    parser.add_argument(
        "--dask", metavar="tcp://HOST:PORT", help="a Dask scheduler; or tls://"
    )
    _add_options(parser)
    parser.add_argument("--out", type=Path, required=True, help="a .csv file")
    parser.set_defaults(run=_run_search)


def _run_search(options: argparse.Namespace) -> None:
    """Search and write a table; go on where an interrupted search stopped."""
    world = find_world(options.workspace)
    guide: tuple[tuple[Any, tuple[float, ...]], ...] = ()
    if options.guide:
        known = load_dataset(options.guide)
        asked: Any = world.tasks_in(known.table).tolist()
        if world.further:
            asked = map(tuple, asked)
        guide = tuple(zip(asked, map(tuple, known.policies.tolist()), strict=True))
    given = {"--offset": options.offset, "--skip": options.skip}
    needless = "--offset" if world.further else "--skip"
    if given[needless]:
        raise ValueError(
            f"{needless}={given[needless]}: tasks of {world.name!r} have "
            f"{' and '.join(world.task_names)}; wanted none"
        )
    tasks: tuple[Any, ...]
    if world.further:
        tasks = msc.search.draw_tasks(world, options.tasks, skip=options.skip)
    else:
        tasks = msc.search.grid(options.tasks, options.offset)
    plan = msc.search.SweepPlan(
        world,
        tasks,
        options.seed,
        guide=guide,
        options=msc.search.SearchOptions.parse(options.set),
    )
    out: Path = options.out
    check_output(out, ".csv")
    read_package(out.parent)
    journal = out.with_name(f".{out.name}.partial")
    try:
        table = msc.search.search_tasks(
            plan,
            jobs=options.jobs,
            dask=options.dask,
            journal=journal,
            progress=True,
        )
    except KeyboardInterrupt:
        print("msc: the same command goes on from here", file=sys.stderr)
        raise
    except WorkersLost as error:
        raise ValueError(f"{error}; the same command goes on from here") from None
    guided = ""
    if options.guide:
        is_named = find_table(options.guide) != options.guide
        guided = f" --guide {'' if is_named else 'data/'}{options.guide.name}"
    place = f"--offset {options.offset:.17g}"
    if world.further:
        place = f"--skip {options.skip}"
    command = (
        f"msc search --workspace {options.workspace} --tasks {options.tasks}"
        f" {place} --seed {options.seed}"
        + guided
        + "".join(f" --set {changed}" for changed in plan.options.changed)
        + f" --out data/{out.name}"
    )
    save_table(table, out, command=command, seed=options.seed)
    journal.unlink(missing_ok=True)
    print(
        f"{out}: {len(table)} tasks, at most {table['distance_m'].max():.2g} m missed"
    )


def _add_workspace(parser: argparse.ArgumentParser) -> None:
    """Declare in which world."""
    about = "free (default), obstacles, a world of data/worlds, or a .toml file"
    parser.add_argument("--workspace", metavar="WORLD", default="free", help=about)


def _add_audit(commands: Commands) -> None:
    """Declare `msc audit`."""
    parser = commands.add_parser("audit", help="examine a table of policies")
    parser.add_argument("table", type=Path, help="a .csv file, as data/free.csv")
    parser.add_argument(
        "--workspace",
        metavar="WORLD",
        help="where it was searched; by default as the data package has it",
    )
    parser.add_argument(
        "--sample", type=int, default=36, help="tasks searched again (36)"
    )
    add_seed(parser, 1, "a fresh seed")
    add_jobs(parser)
    _add_options(parser)
    parser.add_argument("--out", type=Path, help="a .json file")
    parser.set_defaults(run=_run_audit)


def _run_audit(options: argparse.Namespace) -> None:
    """Execute a table's policies again, search some again, bisect its jumps."""
    out: Path | None = options.out
    if out:
        check_output(out, ".json")
    found = msc.study.audit_table(
        options.table,
        options.workspace,
        n_sample=options.sample,
        seed=options.seed,
        jobs=options.jobs,
        progress=True,
        options=msc.search.SearchOptions.parse(options.set),
    )
    if out:
        write_json(out, found)
    executed, searched = found["executed"], found["searched"]
    print(
        f"executed again: {executed['identical']} of {found['n_tasks']} distances "
        f"identical, the others within {executed['largest_difference_m']:.1e} m"
    )
    print(
        f"searched again: {searched['n_cheaper']} of {len(searched['task_deg'])} tasks "
        f"cheaper by more than {msc.study.COST_TOLERANCE:.1%}, at most "
        f"{max(0.0, -min(searched['change_of_cost'])):.2%}"
    )
    for jump in found.get("jumps", []):  # tasks on a circle have some
        low, high = jump["located_deg"]
        verdict = "jump" if jump["is_jump"] else "no jump"
        print(f"{verdict} between {low:.10g} and {high:.10g} degrees")


def _add_survey(commands: Commands) -> None:
    """Declare `msc survey`."""
    parser = commands.add_parser("survey", help="measure what fixed the world")
    parser.add_argument("constant", choices=("cut", "layout"), help="which constant")
    add_seed(parser)
    add_jobs(parser)
    _add_options(parser)
    parser.add_argument("--out", type=Path, required=True, help="a .json file")
    parser.set_defaults(run=_run_survey)


def _run_survey(options: argparse.Namespace) -> None:
    """Measure where the circle is cut, or find the first fit layout of obstacles."""
    out: Path = options.out
    check_output(out, ".json")
    ways = {"cut": msc.study.locate_cut, "layout": msc.study.choose_layout}
    how = msc.search.SearchOptions.parse(options.set)
    measure = ways[options.constant]
    write_json(out, measure(seed=options.seed, jobs=options.jobs, options=how))
    print(out)


def _add_render(commands: Commands) -> None:
    """Declare `msc render`."""
    parser = commands.add_parser("render", help="draw a movement of the arm")
    _add_workspace(parser)
    parser.add_argument(
        "--task",
        type=float,
        nargs="+",
        required=True,
        help="task angle, degrees; and whatever else a task of the world has",
    )
    parser.add_argument(
        "--policy",
        type=float,
        nargs="+",
        help="six weights; by default the searched policy of the nearest task",
    )
    parser.add_argument(
        "--skill", type=Path, help="or what a .skops file of msc fit predicts"
    )
    parser.add_argument(
        "--out", type=Path, required=True, help="a .png, .gif or .mp4 file"
    )
    parser.set_defaults(run=_run_render)


def _run_render(options: argparse.Namespace) -> None:
    """Execute a policy and draw what happened: a strip of pictures or a film."""
    out: Path = options.out
    msc.plots.check_suffix(out)
    check_output(out, out.suffix)
    world = find_world(options.workspace)
    n_numbers = len(world.task_names)
    if len(options.task) != n_numbers:
        raise ValueError(
            f"--task has {len(options.task)} numbers; wanted "
            f"{' and '.join(world.task_names)}"
        )
    task: Any = tuple(options.task) if world.further else options.task[0]
    target = world.target(task)
    policy, origin = options.policy, "the given policy"
    if policy is not None and options.skill:
        raise ValueError("--policy and --skill: wanted one of them")
    if options.skill:
        policy, origin = _predicted_policy(world, options.skill, task)
    elif policy is None:
        policy, origin = _nearest_policy(world, options.workspace, task)
    with msc.robot.Arm(world) as arm:
        rollout = arm.execute(policy, task)
    msc.plots.render(world.at(task), rollout, target, out)
    print(f"{out}: {origin} ends {100 * rollout.error:.2f} cm from the target")


def _predicted_policy(world: Workspace, path: Path, task: Any) -> tuple[Any, str]:
    """Return what a skill predicts for a task, and what it is."""
    skill = msc.skills.load_skill(path)
    names = list(getattr(skill, "feature_names_in_", ()))
    if names != list(world.task_names):
        told = ", ".join(names) or "columns without names"
        raise ValueError(
            f"{path}: a skill for tasks of {told}; wanted "
            f"{', '.join(world.task_names)}, as {world.name} has them"
        )
    new = pd.DataFrame([np.atleast_1d(task)], columns=names)
    return skill.predict(new)[0], f"the policy that {path.name} predicts"


def _nearest_policy(world: Workspace, name: str, task: Any) -> tuple[Any, str]:
    """Return the searched policy of the nearest task, and what it is."""
    table = Path(name)
    data = load_dataset(table.with_suffix(".csv") if table.suffix else name)
    tasks = world.tasks_in(data.table)
    points, query = (msc.search.coordinates(world, one) for one in (tasks, [task]))
    nearest = int(find_neighbors(points, query, 1)[0, 0])
    told = ", ".join(f"{number:g}" for number in np.atleast_1d(tasks[nearest])[1:])
    origin = f"the policy searched for {data.task_deg[nearest]:g}°"
    return data.policies[nearest], f"{origin}, {told}" if told else origin


def _add_evaluate(commands: Commands) -> None:
    """Declare `msc evaluate`."""
    parser = commands.add_parser("evaluate", help="compare all methods, many times")
    add_profile(parser)
    add_seed(parser)
    add_jobs(parser)
    _add_out_dir(parser)
    parser.add_argument(
        "--methods", metavar="NAME,…", help="whom to try (all, where that is stale)"
    )
    names = ", ".join(_HEADLINE)
    parser.add_argument(
        "--worlds", metavar="NAME,…", default=names, help=f"in which worlds ({names})"
    )
    about = "in which engine policies are executed (pybullet)"
    parser.add_argument(
        "--engine", choices=msc.robot.ENGINES, default=msc.robot.ENGINES[0], help=about
    )
    parser.add_argument(
        "--recheck",
        action="store_true",
        help="keep what is stale by its code alone, if some sets come out the same",
    )
    parser.set_defaults(run=_run_evaluate)


def _run_evaluate(options: argparse.Namespace) -> None:
    """Study both workspaces; write each one's results as soon as they are there."""
    worlds = [name.strip() for name in options.worlds.split(",")]
    if unknown := [name for name in worlds if name not in _HEADLINE]:
        raise ValueError(
            f"worlds={unknown} are unknown; wanted some of {', '.join(_HEADLINE)}; for "
            "others: msc worlds study"
        )
    folder: Path = options.out_dir
    _check_before(folder, "study", worlds)
    wanted = None if options.methods is None else _split_names(options.methods)
    what = {"profile": options.profile, "seed": options.seed, "jobs": options.jobs}
    what |= {"progress": True}
    for world in worlds:
        study = msc.study.run_study(
            world,
            folder,
            names=wanted,
            recheck=options.recheck,
            engine=options.engine,
            **what,
        )
        _tell_results(folder / f"study_{world}.json", study)
        _tell_failures(study, wanted or [*study["failed"]])
        if wanted is None:  # of policies alone, whatever executes them
            out = folder / f"elbow_{world}.json"
            known = json.loads(out.read_text("utf-8")) if out.is_file() else None
            _tell_results(out, msc.study.run_elbows(world, known=known, **what))


def _add_out_dir(parser: argparse.ArgumentParser) -> None:
    """Declare where results go."""
    where = Path("data/results")
    about = f"a folder ({where.as_posix()})"
    parser.add_argument("--out-dir", type=Path, default=where, help=about)


def _check_before(folder: Path, kind: str, worlds: Sequence[str]) -> None:
    """Refuse, before the work, a folder that takes no results, or tables amiss."""
    if folder.is_file():
        raise ValueError(f"out-dir={folder} is a file; wanted the name of a folder")
    for world in worlds:
        check_output(folder / f"{kind}_{world}.json", ".json")
        for table in (world, f"{world}_test"):
            load_dataset(table)


def _split_names(text: str) -> list[str]:
    """Split names at commas, some of which are in a name, as in "charts, Matérn".

    Of names that begin alike it takes the longest.
    """
    parts, names = [part.strip() for part in text.split(",")], []
    if not all(parts):
        raise ValueError(f"methods={text!r} has an empty name; wanted NAME,…")
    while parts:
        ends = range(len(parts), 0, -1)
        known = (n for n in ends if ", ".join(parts[:n]) in msc.study.METHODS)
        n_parts = next(known, 1)
        names.append(", ".join(parts[:n_parts]))
        parts = parts[n_parts:]
    return names


def _tell_failures(study: Mapping[str, Any], names: Sequence[str]) -> None:
    """Say whose fits failed, and why the first of them did."""
    for name in names:
        if failed := study["failed"].get(name):
            where, why = next(iter(failed.items()))
            print(
                f"msc: {name!r} failed on {len(failed)} of its training sets in "
                f"{study['workspace']!r}, first on {where}: {' '.join(why.split())}",
                file=sys.stderr,
            )


def _add_savings(commands: Commands) -> None:
    """Declare `msc savings`."""
    parser = commands.add_parser("savings", help="search from what methods predict")
    add_seed(parser)
    add_jobs(parser)
    _add_out_dir(parser)
    parser.set_defaults(run=_run_savings)


def _run_savings(options: argparse.Namespace) -> None:
    """Search test tasks of both workspaces from predictions, and from scratch."""
    _check_before(options.out_dir, "savings", _HEADLINE)
    for world in _HEADLINE:
        how = {"seed": options.seed, "jobs": options.jobs, "progress": True}
        found = msc.study.run_savings(world, folder=options.out_dir / "savings", **how)
        _tell_results(options.out_dir / f"savings_{world}.json", found)


def _tell_results(out: Path, found: Any) -> None:
    """Write results, and say where."""
    replace_file(out, msc.study.format_study(found))
    print(out)


def _add_worlds(commands: Commands) -> None:
    """Declare `msc worlds`."""
    parser = commands.add_parser("worlds", help="draw worlds, search and study them")
    steps = "make", "search", "jumps", "study", "bands", "moves", "engines", "judge"
    parser.add_argument("step", choices=steps, help="what to do, in this order")
    parser.add_argument(
        "names",
        metavar="WORLD",
        nargs="*",
        help="which worlds (all that are searched; to search: all)",
    )
    parser.add_argument("--count", type=int, default=24, help="layouts to make (24)")
    add_seed(parser)
    add_jobs(parser)
    parser.add_argument(
        "--dask", metavar="tcp://HOST:PORT", help="a Dask scheduler; or tls://"
    )
    where = Path("data/worlds")
    about = f"their folder ({where.as_posix()})"
    parser.add_argument("--folder", type=Path, default=where, help=about)
    out = Path("data/results/worlds")
    about = f"a folder for jumps and studies ({out.as_posix()})"
    parser.add_argument("--out-dir", type=Path, default=out, help=about)
    parser.set_defaults(run=_run_worlds)


def _run_worlds(options: argparse.Namespace) -> None:
    """Draw worlds; or search, bisect or study those that are not yet."""
    folder: Path = options.folder
    if options.step == "make":
        made = msc.worlds.make_worlds(
            folder, seed=options.seed, count=options.count, progress=True
        )
        print(f"{folder}: {len(made)} worlds")
        return
    searched = options.step != "search"
    names = options.names or msc.worlds.list_worlds(folder, searched=searched)
    how = {"seed": options.seed, "jobs": options.jobs, "dask": options.dask}
    how |= {"progress": True}
    try:
        if options.step == "search":
            msc.worlds.search_worlds(folder, names, **how)
        elif options.step == "jumps":
            msc.worlds.locate_jumps(folder, options.out_dir, names, **how)
        elif options.step == "bands":
            msc.worlds.locate_bands(folder, options.out_dir, names, **how)
            found = msc.worlds.judge_bands(options.out_dir)
            write_json(options.out_dir / "bands.json", found)
        elif options.step == "moves":
            msc.worlds.locate_moves(folder, options.out_dir, names, **how)
        elif options.step == "engines":
            out = options.out_dir / "engines.json"
            msc.worlds.compare_engines(folder, out, names, progress=True)
        elif options.step == "judge":
            out = options.out_dir / "verdicts.json"
            write_json(out, msc.worlds.judge_worlds(folder, options.out_dir))
        else:
            msc.worlds.study_worlds(folder, options.out_dir, names, **how)
    except KeyboardInterrupt:
        print("msc: the same command goes on from here", file=sys.stderr)
        raise
    except WorkersLost as error:
        raise ValueError(f"{error}; the same command goes on from here") from None


def _add_claims(commands: Commands) -> None:
    """Declare `msc claims`."""
    parser = commands.add_parser("claims", help="judge the paper's claims")
    parser.add_argument("--out", type=Path, help="a .json file")
    parser.add_argument("--readme", type=Path, help="a .md file, to be renewed")
    parser.set_defaults(run=_run_claims)


def _run_claims(options: argparse.Namespace) -> None:
    """Hold the measured results against every claim; print the verdicts."""
    out: Path | None = options.out
    readme: Path | None = options.readme
    if out:
        check_output(out, ".json")
    text = ""
    if readme:
        text = readme.read_text(encoding="utf-8")
        msc.claims.with_summary(text, {})  # refuses what has no place for it
    verdicts = msc.claims.judge_all(Path.cwd())
    width = max(len(one.claim.id) for one in verdicts)
    for one in verdicts:
        print(f"{one.claim.id:{width}}  {one.words:18}  {one.measured}")
        if one.differs:
            print(f"{'':{width}}  {'':18}  {one.sentence}")
    for one in verdicts:
        if one.unexplained:
            print(f"{one.claim.id}: {one.verdict}, but no `why` quotes a measurement")
    summary = msc.claims.summarise(verdicts)
    if out:
        write_json(out, summary)
        print(out)
    if readme:
        replace_file(readme, msc.claims.with_summary(text, summary))
        print(readme)


_run, _build = BOOK_COMMANDS
COMMANDS = (
    _add_search,
    _add_audit,
    _add_survey,
    _add_render,
    _add_evaluate,
    _add_savings,
    _add_worlds,
    *FIT_COMMANDS,
    _run,
    _add_claims,
    _build,
)
