"""The path in the reader's hand: the page plans what the package plans."""

import re

import numpy as np
import pytest

from msc import Workspace
from msc.robot import forward_kinematics, inverse_kinematics

PAGE = "method_arm"
SET = """(input, value) => {
  input.value = value;
  input.dispatchEvent(new Event("input", {bubbles: true}));
}"""
POLICIES = {60: [10, -25.5, 40, 3, 12, -9.5], 237: [0] * 6, 0: [-60, 60] * 3}


def plan(task_deg, policy):
    """Return how far from its goal the plan ends (cm), and its energy."""
    world = Workspace.free()
    step, goal = world.physics.time_step, world.target(task_deg)
    times = step * np.arange(world.physics.n_moving + 1)
    start = forward_kinematics(world.home, world.link_lengths)[-1]
    path = world.dmp.path(np.array(policy, dtype=float), start, goal, times)
    joints = inverse_kinematics(path, world.home, world.link_lengths)
    end = forward_kinematics(joints[-1], world.link_lengths)[-1]
    energy = (np.diff(joints, axis=0) ** 2).sum() / step
    return 100 * np.hypot(*(end - goal)), energy


@pytest.mark.parametrize(("task_deg", "policy"), POLICIES.items())
def test_the_page_plans_as_the_arm_does(visit, task_deg, policy):
    with visit(PAGE) as one:
        root = one.page.locator(".msc-hand")
        root.locator("input[name=task]").evaluate(SET, task_deg)
        for k, weight in enumerate(policy):
            root.locator("input[name=weight]").nth(k).evaluate(SET, weight)
        told = root.locator("output").inner_text()
        found = [float(number) for number in re.findall(r"[\d.]+(?= )", told)]
    assert found == pytest.approx(plan(task_deg, policy), abs=0.06)


def test_a_weight_follows_the_keyboard_and_the_buttons(visit):
    with visit(PAGE) as one:
        root = one.page.locator(".msc-hand")
        weight = root.locator("input[name=weight]").first
        path, told = root.locator(".msc-path"), root.locator("output")
        first, words = path.get_attribute("points"), told.inner_text()
        weight.focus()
        one.page.keyboard.press("Home")
        assert path.get_attribute("points") != first
        assert told.inner_text() != words
        root.locator("button[name=zero]").click()
        assert weight.input_value() == "0"
        root.locator("button[name=searched]").click()
        assert path.get_attribute("points") == first
        assert not root.locator(".msc-poster").is_visible()
