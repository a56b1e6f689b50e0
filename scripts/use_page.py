#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Opens report.html in headless chromium, reads its first screen, follows its links, sorts and
scrubs, and looks at every figure; fails on any error of the console and any request to the network. Usage: use_page.py REPORT.html PICTURES"""
import base64
import json
import pathlib
import re
import subprocess
import sys
import time

if {"-h", "--help"} & set(sys.argv[1:]):  # before the libraries below are needed
    print(__doc__)
    sys.exit()

from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

WAIT_S = 60


def open_browser(width, height, dark=False):
    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
                     "--enable-unsafe-swiftshader", "--hide-scrollbars", "--disable-dev-shm-usage",
                     f"--window-size={width},{height}"):
        options.add_argument(argument)
    if dark:
        options.add_argument("--blink-settings=preferredColorScheme=0")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options)
    driver.set_script_timeout(WAIT_S)
    return driver


def open_page(driver, page):
    driver.get(page)
    driver.execute_script("document.documentElement.style.scrollBehavior = 'auto'")


def column(driver, table, number):
    return driver.execute_script(
        "return [...arguments[0].tBodies[0].rows].filter(r => r.offsetParent).map(r => r.cells[arguments[1]])"
        ".map(c => c.textContent.trim())", table, number)


def first_table(driver):
    """The first table of a chapter."""
    return driver.find_element(By.CSS_SELECTOR, "section[id^=chapter] .table table")


def check_first_screen(driver):
    """What was asked, an answer with a number, and a picture stand before any scrolling."""
    bottom = driver.execute_script("return innerHeight")
    for selector in (".origin", "h1", ".answers li", "figure img"):
        top = driver.execute_script("return document.querySelector(arguments[0]).getBoundingClientRect().top", selector)
        assert 0 <= top < bottom, (selector, top)
    assert any(c.isdigit() for c in driver.find_element(By.CSS_SELECTOR, ".answers li").text)
    assert len(driver.find_elements(By.CSS_SELECTOR, "table")) <= 25


def check_contents(driver):
    """Every link of the contents lands on its heading."""
    for link in driver.find_elements(By.CSS_SELECTOR, "nav a"):
        target = link.get_attribute("href").split("#")[1]
        driver.execute_script("location.hash = '#' + arguments[0]", target)
        driver.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
        top, end = driver.execute_script(
            "const e = document.getElementById(arguments[0]);"
            "return [e.getBoundingClientRect().top, scrollY + innerHeight >= document.documentElement.scrollHeight - 2]", target)
        assert abs(top) < 60 or end, (target, top)
    driver.execute_script("history.replaceState(null, '', location.pathname); scrollTo(0, 0)")


def check_more_rows(driver):
    for button in driver.find_elements(By.CSS_SELECTOR, "section[id^=chapter] button.more"):
        table = button.find_element(By.XPATH, "ancestor::div[contains(@class, 'table')][1]")
        hidden = table.find_element(By.CSS_SELECTOR, "tr.rest")
        assert not hidden.is_displayed()
        driver.execute_script("arguments[0].click()", button)
        assert hidden.is_displayed()
        return


def check_sorting(driver, table):
    heads = table.find_elements(By.CSS_SELECTOR, "thead th")
    number = next(i for i, head in enumerate(heads) if "n" in head.get_attribute("class").split())
    before = column(driver, table, number)
    head = heads[number]
    driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", head)
    for press, state in ((head.click, "ascending"), (lambda: head.send_keys(Keys.ENTER), "descending")):
        press()
        assert heads[number].get_attribute("aria-sort") == state, heads[number].get_attribute("aria-sort")
        values = [float(v.split()[0]) for v in column(driver, table, number) if v != "–"]
        assert values == sorted(values, reverse=state == "descending"), (state, values)
    head.click()
    assert column(driver, table, number) == before, "the third press gives the order of the report"


def check_claims(driver):
    """Four columns stand at first; what else is known comes with a click."""
    found = driver.find_elements(By.CSS_SELECTOR, "#claims .table")
    if not found:
        return
    shown = lambda: [head.text for head in found[0].find_elements(By.CSS_SELECTOR, "thead th") if head.is_displayed()]
    assert [name.split()[0] for name in shown()] == ["claim", "verdict", "paper", "ours"], shown()
    driver.execute_script("arguments[0].click()", found[0].find_element(By.CSS_SELECTOR, "button.more"))
    assert len(shown()) > 4, shown()


def check_replay(driver):
    view = driver.find_element(By.ID, "replay-view")
    driver.execute_script("arguments[0].scrollIntoView()", view)
    WebDriverWait(driver, WAIT_S).until(lambda _: view.get_attribute("data-ready") == "true", "the replay starts")
    overlay = lambda: view.find_element(By.CSS_SELECTOR, ".overlay").text
    assert overlay().startswith(("simulated", "recorded")), overlay()
    start = overlay()
    slider = view.find_element(By.CSS_SELECTOR, "input[type=range]")
    driver.execute_script("arguments[0].value = Math.floor(arguments[0].max / 2);"
                          "arguments[0].dispatchEvent(new Event('input', {bubbles: true}))", slider)
    WebDriverWait(driver, WAIT_S).until(lambda _: overlay() != start, "scrubbing changes the instant")
    assert " cm" in overlay(), overlay()
    # frames that playing shows, on this machine without a graphics card
    view.find_element(By.XPATH, ".//button[text()='Play']").click()
    frames = driver.execute_async_script("""
        const done = arguments[0], start = performance.now();
        let frames = 0;
        const count = () => { ++frames; performance.now() - start < 3000 ? requestAnimationFrame(count) : done(frames / 3); };
        requestAnimationFrame(count);""")
    print(f"replay: {frames:.0f} frames a second in software")
    view.find_element(By.XPATH, ".//button[text()='Pause' or text()='Play']").click()


def check_silence(driver):
    errors = [entry["message"] for entry in driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")
              and "GPU stall" not in entry["message"] and "GL Driver" not in entry["message"]]
    assert not errors, errors
    requests = []
    for entry in driver.get_log("performance"):
        message = json.loads(entry["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            url = message["params"]["request"]["url"]
            if not url.startswith(("data:", "blob:")):
                requests.append(url)
    assert all(url.startswith("file:") and url.split("#")[0].endswith((".html", ".svg")) for url in requests), requests


def wide(page, pictures):
    driver = open_browser(1400, 1000)
    try:
        driver.execute_cdp_cmd("Performance.enable", {"timeDomain": "threadTicks"})
        began = time.monotonic()
        open_page(driver, page)
        milliseconds = float(driver.execute_script("return document.documentElement.dataset.interactiveMs"))
        waited_ms = 1e3 * (time.monotonic() - began)
        metrics = {m["name"]: m["value"] for m in driver.execute_cdp_cmd("Performance.getMetrics", {})["metrics"]}
        print(f"interactive after {milliseconds:.0f} ms, loaded after {waited_ms:.0f} ms; "
              f"the page's thread computed {1e3 * metrics['TaskDuration']:.0f} ms")
        driver.save_screenshot(str(pictures / "light.png"))
        check_first_screen(driver)
        check_contents(driver)
        check_more_rows(driver)
        check_sorting(driver, first_table(driver))
        check_claims(driver)
        driver.save_screenshot(str(pictures / "table.png"))
        check_replay(driver)
        driver.save_screenshot(str(pictures / "replay.png"))
        pictured = driver.find_elements(By.CSS_SELECTOR, "figure")
        if pictured:
            driver.execute_script("arguments[0].scrollIntoView()", pictured[0])
            time.sleep(0.5)
            driver.save_screenshot(str(pictures / "figure.png"))
        check_silence(driver)
        pdf = driver.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True, "printBackground": True})
        (pictures / "print.pdf").write_bytes(base64.b64decode(pdf["data"]))
    finally:
        driver.quit()


def dark(page, pictures):
    driver = open_browser(1400, 1000, dark=True)
    try:
        open_page(driver, page)
        back = driver.execute_script("return getComputedStyle(document.body).backgroundColor")
        assert sum(int(part) for part in back[4:-1].split(",")) < 150, f"a dark page is dark: {back}"
        driver.save_screenshot(str(pictures / "dark.png"))
        for name, selector in (("dark-figure", "figure"), ("dark-table", "section[id^=chapter] .table")):
            found = driver.find_elements(By.CSS_SELECTOR, selector)
            if found:
                driver.execute_script("arguments[0].scrollIntoView()", found[0])
                time.sleep(0.5)
                driver.save_screenshot(str(pictures / f"{name}.png"))
        check_silence(driver)
    finally:
        driver.quit()


def phone(page, pictures):
    driver = open_browser(500, 844)
    try:
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                               {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True})
        open_page(driver, page)
        widths = driver.execute_script("return [document.documentElement.scrollWidth, innerWidth]")
        assert widths[0] <= widths[1] <= 390, f"the page scrolls sideways: {widths}"
        driver.save_screenshot(str(pictures / "phone.png"))
        order = driver.execute_script("return ['h1', 'nav', 'main'].map(s => document.querySelector(s).getBoundingClientRect().top)")
        assert order == sorted(order), f"title, contents, sections: {order}"
        assert not driver.find_element(By.CSS_SELECTOR, "nav ol").is_displayed(), "contents are folded"
        for name, selector in (("phone-table", "section[id^=chapter] .table"), ("phone-replay", "#replay"),
                               ("phone-figure", "figure")):
            driver.execute_script("document.querySelector(arguments[0]).scrollIntoView()", selector)
            time.sleep(1.5)
            driver.save_screenshot(str(pictures / f"{name}.png"))
        figure = driver.execute_script("const box = document.querySelector('figure.stacks .pan');"
                                       "return [box.scrollWidth, box.clientWidth, box.clientHeight]")
        assert figure[0] == figure[1] <= 390 < figure[2], f"panels of the first figure stand below each other: {figure}"
        figure = driver.execute_script("const box = document.querySelector('figure:not(.stacks) .pan');"
                                       "return box && [box.scrollWidth, box.clientWidth]")
        assert not figure or (figure[0] > 650 and figure[1] <= 390), f"other figures are read by panning: {figure}"
        hints = driver.execute_script("return [...document.querySelectorAll('.table')].filter(t => { const b = t.querySelector('.scroll');"
                                      "return b && b.scrollWidth > b.clientWidth + 4 && !t.classList.contains('wide'); }).length")
        assert hints == 0, f"{hints} tables hide columns and do not say so"
        widths = driver.execute_script("return [document.documentElement.scrollWidth, innerWidth]")
        assert widths[0] <= widths[1] <= 390, f"the page scrolls sideways: {widths}"
        check_silence(driver)
    finally:
        driver.quit()


OVERLAPS = """
const picture = document.querySelector("svg"), frame = picture.getBoundingClientRect();
const boxes = [...picture.querySelectorAll("text")].filter((t) => t.textContent.trim())
    .map((t) => [t.textContent, t.getBoundingClientRect()]);
const found = [];
for (const [text, b] of boxes)
  if (b.left < frame.left - 1 || b.right > frame.right + 1 || b.top < frame.top - 1 || b.bottom > frame.bottom + 1)
    found.push(`"${text}" is cut off`);
for (let i = 0; i < boxes.length; ++i)
  for (let j = i + 1; j < boxes.length; ++j) {
    const [s, a] = boxes[i], [t, b] = boxes[j];
    const width = Math.min(a.right, b.right) - Math.max(a.left, b.left);
    const height = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
    if (width > 1 && height > 0.25 * Math.min(a.height, b.height)) found.push(`"${s}" and "${t}" overlap`);
  }
return found;
"""


def gallery(folder, pictures):
    """Every figure as PNG; no text of it is cut off or lies on another."""
    pictures.mkdir(parents=True, exist_ok=True)
    driver = open_browser(900, 700)
    figures, problems = sorted(folder.glob("*/*.svg")), []
    try:
        for figure in figures:
            driver.get(figure.as_uri())
            problems += [f"{figure.parent.name}/{figure.name}: {problem}" for problem in driver.execute_script(OVERLAPS)]
            driver.save_screenshot(str(pictures / f"{figure.parent.name}-{figure.stem}.png"))
    finally:
        driver.quit()
    print(f"{len(figures)} figures in the gallery")
    assert not problems, "\n".join(problems)


def printed_figures(folder):
    """The letters of every figure's PDF are of 8 pt, 9 pt high with what reaches above and below, and none is cut off."""
    problems = []
    for figure in sorted(folder.glob("*/*.pdf")):
        boxes = subprocess.run(["pdftotext", "-bbox", figure, "-"], check=True, capture_output=True, text=True).stdout
        width_pt, height_pt = map(float, re.search(r'<page width="([\d.]+)" height="([\d.]+)"', boxes).groups())
        for box in re.finditer(r'<word xMin="(\S+)" yMin="(\S+)" xMax="(\S+)" yMax="(\S+)">(.*)</word>', boxes):
            left, top, right, bottom = map(float, box.groups()[:4])
            if left < -1 or top < -1 or right > width_pt + 1 or bottom > height_pt + 1:
                problems.append(f"{figure.parent.name}/{figure.name}: {box[5]} is cut off")
            if min(right - left, bottom - top) > 9.6:
                problems.append(f"{figure.parent.name}/{figure.name}: the letters of {box[5]} are {bottom - top:.1f} pt high")
    assert not problems, "\n".join(problems[:20])


def main():
    page, pictures = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    print(f"{page.name}: {page.stat().st_size / 1e6:.1f} MB")
    assert page.stat().st_size < 2e6
    for use in (wide, dark, phone):
        use(page.as_uri(), pictures)
    gallery(page.parent / "figures", pictures / "gallery")
    printed_figures(page.parent / "figures")
    print("read, sorted, scrubbed and printed; no error and no request")


if __name__ == "__main__":
    main()
