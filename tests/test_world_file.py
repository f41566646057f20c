"""Worlds as files: what is written is read again, what cannot be is told in a line."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from msc import DMP, Workspace
from msc.robot import (
    ENGINES,
    ControllerGains,
    CostWeights,
    Physics,
    TaskRange,
    format_world,
    read_world,
)

FULL = """
name = "of all kinds"

[units]
length = "cm"
angle = "deg"
mass = "g"

[arm]
link_lengths = [40, 35, 25]
link_masses = [1000, 800, 500]
home = [-168.9, 40.5, 40.5]

[goals]
radius = 45
cut = 60

[tasks]
radius = [30, 45]
turn = [-5, 5]

[[obstacles]]
x = 70
y = 30
radius = 5

[cost]
contact = 0.01

[policy]
n_basis = 5

[controller]
torque_limit = [inf, 20, 5]

[physics]
engine = "mujoco"
gravity = 9.81
"""


@pytest.fixture
def read(tmp_path):
    """Read a world from a file of this text."""
    file = tmp_path / "mine.toml"

    def write_and_read(text):
        file.write_text(text, encoding="utf-8")
        return read_world(file)

    return write_and_read


def test_a_file_says_what_a_workspace_has(read):
    home = tuple(np.deg2rad([-168.9, 40.5, 40.5]).tolist())
    assert read(FULL) == Workspace(
        name="of all kinds",
        home=home,
        cut_deg=60.0,
        circles=((0.7, 0.3, 0.05),),
        further=(TaskRange("radius_m", 0.3, 0.45), TaskRange("turn_deg", -5.0, 5.0)),
        cost=CostWeights(contact=0.01),
        dmp=DMP(n_basis=5),
        controller=ControllerGains(torque_limit=(math.inf, 20, 5)),
        physics=Physics(engine="mujoco", gravity=9.81),
    )


def test_what_is_left_out_is_as_usual_and_the_file_names_the_world(read):
    assert read("") == replace(Workspace.free(), name="mine")


@pytest.mark.parametrize("name", ["free", "obstacles"])
def test_the_ready_worlds_are_read_as_they_were_written(read, name):
    world = Workspace.named(name)
    assert read(format_world(world, "Two lines\nof comment.")) == world


def test_units_say_what_numbers_mean(read):
    metric = read("[goals]\nradius = 0.4\ncut = 90\n[arm]\nhome = [180, 30, 30]")
    for length, radius in (("mm", 400), ("cm", 40), ("m", 0.4)):
        told = (
            f'[units]\nlength = "{length}"\nangle = "rad"\n[goals]\nradius = {radius}'
        )
        told += f"\ncut = {math.pi / 2}\n[arm]\nhome = {[*metric.home]}"
        found = read(told)
        np.testing.assert_array_max_ulp(np.array(found.home), np.array(metric.home))
        assert found.goal_radius == pytest.approx(0.4, rel=1e-15)
        assert found.cut_deg == pytest.approx(90, rel=1e-15)


positive = st.floats(0.01, 50)
unlike = st.characters(codec="utf-8")


@st.composite
def worlds(draw):
    """Draw any world that can be."""
    angles = st.floats(-400, 400).map(lambda angle: round(angle, 3))
    home = tuple(np.deg2rad(draw(st.tuples(angles, angles, angles))).tolist())
    lengths = draw(st.tuples(*[st.floats(0.3, 0.5)] * 3))
    further = [("radius_m", 0.3, draw(st.floats(0.31, 0.5)))]
    further += [("turn_deg", draw(st.floats(-9, -1)), draw(st.floats(1, 9)))]
    kept = draw(st.sets(st.integers(0, 1)))
    circles = st.tuples(*[st.floats(-1, 1)] * 2, st.floats(0.01, 0.05))
    try:
        return Workspace(
            name=draw(st.text(unlike, min_size=1)),
            link_lengths=lengths,
            link_masses=draw(st.tuples(*[positive] * 3)),
            home=home,
            goal_radius=draw(st.floats(0.26, 0.8)),
            cut_deg=draw(st.floats(-360, 360)),
            circles=draw(st.lists(circles, max_size=2)),
            further=tuple(further[k] for k in kept),
            cost=draw(st.builds(CostWeights, *[st.floats(0, 1e6)] * 4)),
            dmp=draw(
                st.builds(
                    DMP,
                    spring=positive,
                    damping=st.none() | positive,
                    n_basis=st.integers(2, 9),
                    gated=st.booleans(),
                )
            ),
            controller=draw(
                st.builds(
                    ControllerGains,
                    st.floats(0, 1000),
                    st.floats(0, math.inf),
                    st.tuples(*[st.floats(1e-9, math.inf)] * 3),
                )
            ),
            physics=draw(
                st.builds(
                    Physics,
                    engine=st.sampled_from(ENGINES),
                    control_rate=st.floats(10, 1000),
                    substeps=st.integers(1, 100),
                    duration=st.floats(0.1, 20),
                    settling=st.floats(0, 5),
                    gravity=st.floats(0, 30),
                )
            ),
        )
    except ValueError:  # an obstacle somewhere that it cannot be
        assume(False)


@settings(deadline=None)
@given(worlds())
def test_any_world_is_read_as_it_was_written(tmp_path_factory, world):
    file = tmp_path_factory.getbasetemp() / "any.toml"
    file.write_text(format_world(world), encoding="utf-8", newline="\n")
    again = read_world(file)
    assert again == world
    assert repr(again) == repr(world)


@settings(deadline=None)
@given(st.tuples(*[st.floats(-7, 7)] * 3))
def test_a_home_of_whatever_angles_is_read_to_their_last_digit(tmp_path_factory, home):
    file = tmp_path_factory.getbasetemp() / "home.toml"
    file.write_text(format_world(Workspace(home=home)), encoding="utf-8")
    np.testing.assert_array_max_ulp(np.array(read_world(file).home), np.array(home))


def test_a_name_may_have_any_signs(read):
    world = Workspace(name='\x7f\x00\n"\\é')
    assert read(format_world(world)) == world


def test_numpy_s_numbers_are_written_as_numbers(read):
    world = Workspace(name="np", goal_radius=np.float64(0.4), cut_deg=np.int64(60))
    assert read(format_world(world)) == world


TWO = "[[obstacles]]\nx = 0.7\ny = 0.3\nradius = 0.05\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[arms]", r"the file has an unknown key 'arms'; wanted arm"),
        ("[goals]\nradus = 1", r"\[goals\] has an unknown key 'radus'; wanted radius"),
        ('[units]\nlength = "ft"', r"\[units\] length = 'ft' .*; wanted one of m, cm"),
        ("[units]\nangle = 3", r"\[units\] angle = 3 .*; wanted one of deg, rad"),
        ('[units]\ntime = "s"', r"\[units\] has an unknown key 'time'; wanted"),
        (
            '[physics]\nengine = "ode"',
            r"\[physics\] engine='ode'; wanted 'pybullet' or",
        ),
        ("[physics]\nsubsteps = 4.5", r"\[physics\] substeps=4.5; wanted at least 1"),
        ("[physics]\ngravity = true", r"\[physics\] gravity=True; wanted a finite"),
        ('[cost]\nerror = "1"', r"\[cost\] error=1; wanted a finite number"),
        ("[cost]\nerrors = 1", r"\[cost\] has an unknown key 'errors'; wanted error"),
        ("[policy]\ngated = 1", r"\[policy\] gated=1; wanted True or False"),
        (
            '[controller]\ntorque_limit = ["1", "1", "1"]',
            r"\[controller\] torque_limit=.*; wanted 3 positive numbers",
        ),
        ("name = 3", r"name = 3; wanted a text"),
        ('name = ""', r"name = ''; wanted a text"),
        ("goals = 3", r"goals = 3; wanted a section, \[goals\]"),
        ("[obstacles]\nx = 1", r"obstacles: wanted sections, one \[\[obstacles\]\]"),
        ("obstacles = [3]", r"obstacles: wanted sections, one \[\[obstacles\]\]"),
        ('[goals]\nradius = "0.4"', r"\[goals\] radius = '0.4'; wanted numbers"),
        ("[goals]\nradius = true", r"\[goals\] radius = True; wanted numbers"),
        ("[goals]\nradius = 1979-05-27", r"\[goals\] radius must hold numbers"),
        ("[goals]\nradius = [0.4]", r"goal_radius=.*; wanted one number"),
        ("[goals]\nradius = nan", r"goal_radius=nan m is out of the arm's reach"),
        ("[goals]\nradius = 1.5", r"goal_radius=1.5 m is out of the arm's reach"),
        ("[arm]\nhome = [1, 2]", r"home=.*; wanted 3 angles"),
        ("[arm]\nhome = [1, [2]]", r"\[arm\] home must hold numbers"),
        ("[arm]\nlink_masses = [1, 1]", r"link_masses=.*; wanted 3 positive numbers"),
        ("[tasks]\nradius = 0.4", r"\[tasks\] radius = 0.4; wanted two numbers"),
        ("[tasks]\nradius = [[1], [2]]", r"radius_m=\[1.0\]; wanted a finite number"),
        ("[tasks]\nradius = [0.4, 0.3]", r"radius_m=.*; wanted .* the lower one first"),
        ("[tasks]\nradius = [0.4, 2]", r"radius_m=2.0 m is out of the arm's reach"),
        ("[tasks]\nspeed = [1, 2]", r"\[tasks\] has an unknown key 'speed'; wanted"),
        ("[tasks]\nheight = [0, 1]", r"height_m: no obstacle to move; wanted one"),
        (TWO + "z = 1", r"\[\[obstacles\]\] 1 has an unknown key 'z'; wanted x"),
        ("[[obstacles]]\nx = 1", r"\[\[obstacles\]\] 1 lacks y, radius"),
        (TWO + TWO, r"circles: the obstacles .* overlap; wanted them apart"),
        (
            "[[obstacles]]\nx = -0.2\ny = 0.0\nradius = 0.2",
            r"circles: .* stands in the arm's home pose; wanted one clear of it",
        ),
        (
            "[[obstacles]]\nx = 0.45\ny = 0.0\nradius = 0.1",
            r"circles: the goals pass through the obstacle .* cannot be reached",
        ),
        (
            "[tasks]\nheight = [0, 0.2]\n" + TWO + TWO.replace("0.3", "0.5"),
            r"circles: the obstacles .* overlap",
        ),
        (
            "[tasks]\nheight = [-0.4, 0]\n" + TWO.replace("0.7", "0.4"),
            r"circles: the goals pass through the obstacle",
        ),
        ("[goals", r"wanted TOML: Expected"),
    ],
)
def test_what_cannot_be_is_told_by_file_and_field(read, text, said):
    with pytest.raises(ValueError, match=rf"^mine\.toml: {said}") as raised:
        read(text)
    assert "\n" not in str(raised.value)


def test_a_thin_obstacle_is_met_wherever_it_passes(read):
    """5 mm of 80 cm, between two places of the moving one."""
    pin = "[[obstacles]]\nx = 0.72\ny = 0.2275\nradius = 0.001\n"
    moving = "[[obstacles]]\nx = 0.72\ny = 0.0\nradius = 0.004\n"
    read(moving + pin)
    with pytest.raises(ValueError, match="overlap"):
        read("[tasks]\nheight = [0.0, 0.6]\n" + moving + pin)


def test_a_file_that_is_missing_or_no_text_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"^no\.toml: cannot be read: No such file"):
        read_world(tmp_path / "no.toml")
    with pytest.raises(ValueError, match=r": cannot be read: Is a directory"):
        read_world(tmp_path)
    (tmp_path / "bytes.toml").write_bytes(b"name = '\xff'")
    with pytest.raises(ValueError, match=r"^bytes\.toml: wanted TOML: .*utf-8"):
        read_world(tmp_path / "bytes.toml")


def test_what_is_no_world_is_not_written():
    with pytest.raises(TypeError, match="workspace='free'; wanted a Workspace"):
        format_world("free")
