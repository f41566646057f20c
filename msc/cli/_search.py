"""The commands on tables of policies: search, audit, survey, render.

The simulator and the search, which take seconds to load, are imported by the commands
that need them.
"""

import argparse
import re
import sys
from pathlib import Path

from msc._parallel import WorkersLost
from msc.data import load_dataset, read_package, save_table
from msc.robot import Workspace
from press import Commands, add_jobs, add_seed, check_output, write_json


def _add_search(commands: Commands) -> None:
    """Declare `msc search`."""
    parser = commands.add_parser("search", help="search the policies of many tasks")
    parser.add_argument("--workspace", default="free", help="free (default), obstacles")
    parser.add_argument("--tasks", type=int, default=72, help="how many (72)")
    parser.add_argument("--offset", type=float, default=0.0, help="first angle (0)")
    parser.add_argument("--guide", type=Path, help="a table: neighbours to start from")
    add_seed(parser)
    add_jobs(parser)
    parser.add_argument(
        "--dask", metavar="tcp://HOST:PORT", help="a Dask scheduler; or tls://"
    )
    parser.add_argument("--out", type=Path, required=True, help="a .csv file")
    parser.set_defaults(run=_run_search)


def _run_search(options: argparse.Namespace) -> None:
    """Search and write a table; go on where an interrupted search stopped."""
    from msc.search import SweepPlan, grid, search_tasks

    guide: tuple[tuple[float, tuple[float, ...]], ...] = ()
    if options.guide:
        _, policies, known = load_dataset(options.guide)
        guide = tuple(
            zip(known["task_deg"], map(tuple, policies.tolist()), strict=True)
        )
    plan = SweepPlan(
        Workspace.named(options.workspace),
        grid(options.tasks, options.offset),
        options.seed,
        guide=guide,
    )
    out: Path = options.out
    check_output(out, ".csv", jobs=options.jobs, seed=options.seed)
    read_package(out.parent)
    journal = out.with_name(f".{out.name}.partial")
    try:
        table = search_tasks(
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
    command = (
        f"msc search --workspace {options.workspace} --tasks {options.tasks}"
        f" --offset {options.offset:.17g} --seed {options.seed}"
        + (f" --guide data/{options.guide.name}" if options.guide else "")
        + f" --out data/{out.name}"
    )
    save_table(table, out, command=command, seed=options.seed)
    journal.unlink(missing_ok=True)
    print(
        f"{out}: {len(table)} tasks, at most {table['distance_m'].max():.2g} m missed"
    )


def _add_audit(commands: Commands) -> None:
    """Declare `msc audit`."""
    parser = commands.add_parser("audit", help="examine a table of policies")
    parser.add_argument("table", type=Path, help="a .csv file, as data/free.csv")
    parser.add_argument(
        "--workspace", help="free, obstacles; by default as the data package has it"
    )
    parser.add_argument("--sample", type=int, default=36, help="tasks searched again")
    add_seed(parser, 1, "a fresh seed")
    add_jobs(parser)
    parser.add_argument("--out", type=Path, help="a .json file")
    parser.set_defaults(run=_run_audit)


def _run_audit(options: argparse.Namespace) -> None:
    """Execute a table's policies again, search some again, bisect its jumps."""
    from msc.search import LOWER, audit_table

    out: Path | None = options.out
    if out:
        check_output(out, ".json", jobs=options.jobs, seed=options.seed)
    found = audit_table(
        options.table,
        options.workspace,
        n_sample=options.sample,
        seed=options.seed,
        jobs=options.jobs,
        progress=True,
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
        f"cheaper by more than {LOWER:.1%}, at most "
        f"{max(0.0, -min(searched['change_of_cost'])):.2%}"
    )
    for jump in found["jumps"]:
        low, high = jump["located_deg"]
        verdict = "jump" if jump["is_jump"] else "no jump"
        print(f"{verdict} between {low:.10g} and {high:.10g} degrees")


def _add_survey(commands: Commands) -> None:
    """Declare `msc survey`."""
    parser = commands.add_parser("survey", help="measure what fixed the world")
    parser.add_argument("constant", choices=("cut", "layout"), help="which constant")
    add_seed(parser)
    add_jobs(parser)
    parser.add_argument("--out", type=Path, required=True, help="a .json file")
    parser.set_defaults(run=_run_survey)


def _run_survey(options: argparse.Namespace) -> None:
    """Measure where the circle is cut, or find the first fit layout of obstacles."""
    from msc.search import choose_layout, locate_cut

    out: Path = options.out
    check_output(out, ".json", jobs=options.jobs, seed=options.seed)
    if options.constant == "cut":
        found = locate_cut(seed=options.seed, jobs=options.jobs)
    else:
        found = choose_layout(seed=options.seed, jobs=options.jobs)
    write_json(out, found)
    print(out)


def _add_render(commands: Commands) -> None:
    """Declare `msc render`."""
    parser = commands.add_parser("render", help="draw a movement of the arm")
    parser.add_argument("--workspace", default="free", help="free (default), obstacles")
    parser.add_argument("--task", type=float, required=True, help="task angle, degrees")
    parser.add_argument(
        "--policy",
        type=float,
        nargs="+",
        help="six weights; by default the searched policy of the nearest task",
    )
    parser.add_argument(
        "--out", type=Path, required=True, help="a .png, .gif or .mp4 file"
    )
    # argparse takes -1e-3 for an option: of numbers it knows -1 and -0.001 only.
    parser._negative_number_matcher = re.compile(r"-(\.?\d|inf|nan)")
    parser.set_defaults(run=_run_render)


def _run_render(options: argparse.Namespace) -> None:
    """Execute a policy and draw what happened: a strip of pictures or a film."""
    from msc.plots import check_suffix, render
    from msc.robot import Arm

    out: Path = options.out
    check_suffix(out)
    check_output(out, out.suffix)
    world = Workspace.named(options.workspace)
    target = world.target(options.task)
    policy, origin = options.policy, "the given policy"
    if policy is None:
        _, policies, table = load_dataset(options.workspace)
        gaps = (table["task_deg"] - options.task + 180) % 360 - 180
        nearest = int(gaps.abs().argmin())
        policy = policies[nearest]
        origin = f"the policy searched for {table['task_deg'][nearest]:g}°"
    with Arm(world) as arm:
        rollout = arm.execute(policy, options.task)
    render(world, rollout, target, out)
    print(f"{out}: {origin} ends {100 * rollout.error:.2f} cm from the target")


COMMANDS = (_add_search, _add_audit, _add_survey, _add_render)
