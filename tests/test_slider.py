import json
import re

import matplotlib.pyplot as plt
import pytest

from msc.plots._slider import Mark, Panel, Slider, choose_ticks


def picture():
    figure = plt.figure(figsize=(1, 1))
    plt.close(figure)
    return figure


def slider(marks, n_steps=2, captions=("a", "b"), **more):
    panel = Panel("two dots & a line", (0, 2), (0, 1), marks)
    labels = [f"{k} degrees" for k in range(n_steps)]
    parts = {"poster": picture(), "poster_alt": "a <picture>", **more}
    return Slider("task angle", labels, captions, [panel], **parts)


def data_of(html):
    """Read the numbers that the page's script is given."""
    found = re.search(r"previousElementSibling,(.*)\);</script>$", html, re.DOTALL)
    return json.loads(found[1])


still = Mark("line", [[0, 0], [2, 1]])
moving = Mark("dots", [[[0, 0]], [[1, 0.5]]], "step")
film = Mark("line", [[[[0, 0], [1, 1]]] * 3] * 2, "time", trail={"width": 1})


def test_coordinates_are_whole_thousandths_of_the_shorter_side():
    data = data_of(slider([still, moving, film]).to_html())
    (panel,) = data["panels"]
    assert panel["scale"] == 1000
    first, second, third = (mark["points"] for mark in panel["marks"])
    assert first == [0, 0, 2000, 1000]
    assert second == [[0, 0], [1000, 500]]
    assert third == [[[0, 0, 1000, 1000]] * 3] * 2
    assert data["n_times"] == 3
    assert data["labels"] == ["0 degrees", "1 degrees"]


def test_the_page_needs_no_other_file_and_is_usable_without_eyes_or_script():
    html = slider([still, moving]).to_html()
    assert "http" not in html.replace("http://www.w3.org", "")
    assert 'aria-label="two dots &amp; a line"' in html
    assert 'alt="a &lt;picture&gt;"' in html
    assert re.search(r'<label>task angle <input name="step" type="range"', html)
    assert "<button" not in html
    assert "<button" in slider([film]).to_html()


def test_play_walks_through_steps_if_asked_to():
    html = slider([still, moving], walks=True).to_html()
    assert "<button" in html
    assert data_of(html)["walks"] is True
    assert data_of(slider([film]).to_html())["walks"] is False


def test_ticks_have_names_or_their_numbers():
    def names(**more):
        ticks = {"x_label": "x", "y_ticks": (0.0, 0.5), **more}
        panel = Panel("axes", (0, 2), (0, 1), [still], **ticks)
        one = Slider("step", ["a"], ["b"], [panel], picture(), "")
        return data_of(one.to_html())["panels"][0]["y_names"]

    assert names() == ["0", "0.5"]
    assert names(y_names=("1", "3.2")) == ["1", "3.2"]


def test_ticks_lie_within_the_axis():
    assert choose_ticks(0, 1) == (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
    assert choose_ticks(-0.05, 0.012) == (-0.04, -0.02, 0.0)


def test_a_caption_cannot_end_the_script():
    html = slider([still], captions=("</script>", "b")).to_html()
    assert html.count("</script>") == 1
    assert data_of(html)["captions"][0] == "</script>"


def test_paper_gets_the_picture():
    bundle = slider([still])._repr_mimebundle_()
    assert set(bundle) == {"text/html", "image/png", "text/plain"}


def test_the_same_drawing_is_the_same_bytes():
    assert slider([still, film]).to_html() == slider([still, film]).to_html()


def test_too_few_shapes_are_refused():
    with pytest.raises(ValueError, match=r"varies by step has 2 shapes; .* 3"):
        slider([moving], n_steps=3, captions="abc")


def test_too_few_captions_are_refused():
    with pytest.raises(ValueError, match=r"captions: 2 of them; .* 3"):
        slider([still], n_steps=3)
