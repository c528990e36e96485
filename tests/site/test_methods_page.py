# SPDX-License-Identifier: Apache-2.0
"""The page of compare-methods in a browser."""

import json
import os
import pathlib
import subprocess

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.support.select import Select

REFERENCES = pathlib.Path(__file__).resolve().parents[1] / "quality" / "references"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The page in a folder with a blank in its name, and the rows of the command."""
    folder = tmp_path_factory.mktemp("a b")
    done = subprocess.run(
        [os.environ["RACKFOCUS"], "compare-methods", REFERENCES / "posts_pinhole.exr",
         "--reference", REFERENCES / "posts_reference.exr", "--repeats", "1", "--json",
         "-q", "--html", folder / "my methods.html"],
        check=True, capture_output=True,
    )  # fmt: skip
    return folder / "my methods.html", json.loads(done.stdout)


@pytest.fixture
def driver(made):
    options = webdriver.ChromeOptions()
    for argument in ["headless=new", "no-sandbox", "window-size=1280,900"]:
        options.add_argument("--" + argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    # Chromium leaves folders behind: among those of the test.
    service = Service(env={**os.environ, "TMPDIR": str(made[0].parent)})
    driver = webdriver.Chrome(options=options, service=service)
    driver.get(made[0].as_uri())
    yield driver
    complaints = driver.get_log("browser")
    driver.quit()
    assert complaints == []


def pictures(driver):
    """File names of both pictures, which must have been loaded."""
    names = []
    for side in ("left", "right"):
        picture = driver.find_element(By.ID, side + "-picture")
        script = "const p = arguments[0]; return p.decode().then(() => p.naturalWidth)"
        assert driver.execute_script(script, picture) == 480
        names.append(picture.get_attribute("src").rsplit("/", 1)[1])
    return names


def visible_from(driver):
    """Where the right picture begins, of its width."""
    return driver.execute_script(
        "return document.getElementById('right-picture').style.clipPath"
    ).split(" ")[-1]


def test_any_two_pictures(driver, made):
    """All results are offered; the best is shown against the reference at first."""
    rows = made[1]
    best = max(rows, key=lambda row: row["tpsnr"])["name"]
    offered = [o.text for o in Select(driver.find_element(By.ID, "left")).options]
    assert offered == ["reference"] + [row["name"] for row in rows]
    assert pictures(driver) == ["reference.png", f"{best}.png"]
    Select(driver.find_element(By.ID, "left")).select_by_visible_text("box coc")
    Select(driver.find_element(By.ID, "right")).select_by_visible_text("pinhole")
    assert pictures(driver) == ["box_coc.png", "pinhole.png"]
    driver.find_element(By.ID, "error").click()
    assert pictures(driver) == ["box_coc_error.png", "pinhole_error.png"]


def test_wipe(driver):
    assert visible_from(driver).startswith("50%")
    stage = driver.find_element(By.ID, "left-picture")
    ActionChains(driver).move_to_element_with_offset(stage, -120, 0).click().perform()
    assert visible_from(driver).startswith("25")
    driver.find_element(By.ID, "wipe").send_keys("\ue012")  # the left arrow
    assert float(visible_from(driver).split("%")[0]) < 25


def test_table(driver, made):
    """Its figures are the command's; a heading sorts, a click shows."""
    column = [cell.text for cell in driver.find_elements(By.CSS_SELECTOR, "th")]
    at = column.index("FLIP")
    driver.find_elements(By.CSS_SELECTOR, "th")[at].click()
    cells = [
        [cell.text for cell in row.find_elements(By.TAG_NAME, "td")]
        for row in driver.find_elements(By.CSS_SELECTOR, "tbody tr")
    ]
    flips = {row["name"]: row["flip"] for row in made[1]}
    shown = [(float(row[at]), row[0].rstrip(" ◀▶")) for row in cells if row[at]]
    assert [name for _, name in shown] == sorted(flips, key=flips.get)
    assert all(abs(flip - flips[name]) < 1e-4 for flip, name in shown)
    driver.find_elements(By.CSS_SELECTOR, "tbody tr")[-1].click()
    assert pictures(driver)[1] == shown[-1][1].replace(" ", "_") + ".png"
