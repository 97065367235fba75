#!/usr/bin/python3
"""The report in a browser without a screen: test_browser.py REPORT.html [SCREENSHOTS]. Skipped without Chromium."""
import base64
import os
import re
import shutil
import sys
import time
import unittest

REPORT, SCREENSHOTS = "", ""
MISSING = [p for p, there in (("chromium", shutil.which("chromium")), ("chromium-driver", shutil.which("chromedriver"))) if not there]
try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.ui import Select
except ImportError:
    MISSING.append("python3-selenium")

DESKTOP, PHONE = (1280, 900), (375, 812)


def start():
    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars"):
        options.add_argument(argument)
    options.binary_location = shutil.which("chromium")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)


class InTheBrowser(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.driver = start()
        cls.addClassCleanup(cls.driver.quit)

    def setUp(self):
        self.show(*DESKTOP)

    def show(self, width, height, dark=False, address=""):
        d = self.driver
        d.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": [
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}, {"name": "prefers-reduced-motion", "value": "reduce"}]})
        d.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": 1,
                                                                  "mobile": width < 600})
        d.get("about:blank")
        d.get(f"file://{REPORT}{address}")

    def run_script(self, code, *arguments):
        return self.driver.execute_script(code, *arguments)

    def until(self, code, *arguments):
        """Waits until the script returns something true, and returns that."""
        end = time.monotonic() + 10
        while time.monotonic() < end:
            found = self.run_script(code, *arguments)
            if found:
                return found
            time.sleep(0.03)
        return self.fail(f"did not become true: {code}")

    def opened(self, kind, article):
        """The first drawing of a kind in an article, started."""
        place = self.driver.find_element(By.CSS_SELECTOR, f"#{article} [data-kind={kind}]")
        self.run_script("arguments[0].scrollIntoView()", place)
        self.until("return arguments[0].querySelector('svg:not(.sample)')", place)
        return place

    def picture(self, place):
        """What a drawing shows, as text: its shapes, not its words."""
        return self.run_script("return [...arguments[0].querySelectorAll('svg:not(.sample) path, svg:not(.sample) image, svg:not(.sample) circle')]"
                               ".map((e) => e.outerHTML).join('')", place)

    def keep(self, name):
        if SCREENSHOTS:
            os.makedirs(SCREENSHOTS, exist_ok=True)
            with open(os.path.join(SCREENSHOTS, name + ".png"), "wb") as file:
                file.write(base64.b64decode(self.driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})["data"]))

    def test_no_errors_and_nothing_loaded_from_elsewhere(self):
        self.driver.get_log("browser")
        self.driver.get_log("performance")
        self.show(*DESKTOP)
        for place in self.driver.find_elements(By.CSS_SELECTOR, "[data-source]"):
            self.run_script("arguments[0].scrollIntoView()", place)
            self.until("return arguments[0].querySelector('svg:not(.sample)')", place)
        self.assertEqual([e["message"] for e in self.driver.get_log("browser")], [])
        asked = [e["message"] for e in self.driver.get_log("performance") if "Network.requestWillBeSent\"" in e["message"]]
        self.assertTrue(asked)
        self.assertEqual([m[:300] for m in asked if '"url":"http' in m], [])

    def test_every_figure_is_visible(self):
        count = self.run_script("for (const i of document.images) i.loading = 'eager'; return document.images.length")
        self.assertGreater(count, 8)
        self.until("return [...document.images].every((i) => i.complete)")
        bad = self.run_script("return [...document.images].filter((i) => !i.closest('#large')).filter((i) => i.naturalWidth < 100 || i.getBoundingClientRect().width < 300 "
                              "|| i.getBoundingClientRect().height < 100).map((i) => i.alt)")
        self.assertEqual(bad, [])

    def test_a_figure_enlarges_whole(self):
        for size in (DESKTOP, PHONE):
            self.show(*size)
            button = self.driver.find_element(By.CSS_SELECTOR, "article button.figure")
            self.run_script("arguments[0].click()", button)
            self.until("const i = document.querySelector('#large img'); return i.complete && i.naturalWidth > 0")
            left, top, right, bottom, width, height = self.run_script(
                "const r = document.querySelector('#large img').getBoundingClientRect();"
                "return [r.left, r.top, r.right, r.bottom, innerWidth, innerHeight]")
            self.assertTrue(left >= 0 and top >= 0 and right <= width and bottom <= height, (left, top, right, bottom))
            self.assertGreater(right - left, 0.9 * width)
            self.assertEqual(self.run_script("return getComputedStyle(document.querySelector('#large img')).objectFit"), "contain")
            self.driver.switch_to.active_element.send_keys(Keys.ESCAPE)
            self.until("return !document.getElementById('large').open")

    def test_verdicts_stay_in_sight(self):
        self.show(800, 900)
        self.run_script("for (const d of document.querySelectorAll('details.table')) d.open = true")
        hidden = self.run_script("""
            const bad = [];
            for (const place of document.querySelectorAll('.scroll')) {
              const cell = place.querySelector('tbody td.v');
              if (!cell) continue;
              for (const x of [0, place.scrollWidth]) {
                place.scrollLeft = x;
                const c = cell.getBoundingClientRect(), p = place.getBoundingClientRect();
                if (c.right > p.right + 1 || c.left < p.left - 1 || c.width < 20) bad.push(place.getAttribute('aria-label'));
              }
            }
            return bad;""")
        self.assertEqual(hidden, [])
        self.assertGreater(self.run_script("return [...document.querySelectorAll('.scroll')].filter((p) => p.querySelector('td.v') && "
                                           "p.scrollWidth > p.clientWidth).length"), 0)

    def test_tables_sort_find_and_choose_verdicts(self):
        table = self.driver.find_element(By.CSS_SELECTOR, "#result-msa-sweep [aria-label='Table position'] table")
        self.run_script("arguments[0].closest('details').open = true", table)

        def column(name):
            return self.run_script("""const t = arguments[0], i = [...t.tHead.rows[0].cells].findIndex((c) => c.textContent.startsWith(arguments[1]));
                return [...t.tBodies[0].rows].filter((r) => !r.hidden).map((r) => r.cells[i].textContent)""", table, name)

        def number(text):
            return float(text.split(" [")[0].replace("−", "-").replace("\u202f", "")) if text[:1] in "−0123456789" else None

        before = column("Monte Carlo")
        head = table.find_element(By.XPATH, ".//th[starts-with(normalize-space(.), 'Monte Carlo')]")
        sort = head.find_element(By.CSS_SELECTOR, "button.sort")
        for direction in (1, -1):
            self.run_script("arguments[0].click()", sort)
            values = [number(t) for t in column("Monte Carlo") if number(t) is not None]
            self.assertEqual(values, sorted(values)[::direction])
            self.assertEqual(head.get_attribute("aria-sort"), "ascending" if direction == 1 else "descending")
        self.run_script("arguments[0].click()", sort)
        self.assertEqual(column("Monte Carlo"), before)
        bar = self.run_script("return arguments[0].closest('.scroll').previousElementSibling", table)
        bar.find_element(By.CSS_SELECTOR, "input").send_keys("joint vertical")
        self.assertTrue(column("quantity") and all("vertical" in q for q in column("quantity")))
        self.assertEqual(set(column("formulation")), {"joint"})
        self.assertIn(f"{len(column('quantity'))} of {len(before)} rows", bar.text)
        bar.find_element(By.CSS_SELECTOR, "input").clear()
        bar.find_element(By.CSS_SELECTOR, "input").send_keys(" ")
        Select(bar.find_element(By.CSS_SELECTOR, "select")).select_by_value("finding")
        self.assertEqual({v.split(" ", 1)[1] for v in column("verdict")}, {"finding"})
        overview = self.driver.find_element(By.CSS_SELECTOR, "table.overview")
        self.run_script("arguments[0].closest('.scroll').previousElementSibling.querySelector('input').value = 'reliability';"
                        "arguments[0].closest('.scroll').previousElementSibling.querySelector('input').dispatchEvent(new Event('input'))", overview)
        self.assertEqual(self.run_script("return [...arguments[0].tBodies[0].rows].filter((r) => !r.hidden).length", overview), 2)

    def test_contents_lead_to_their_parts_with_the_keyboard(self):
        body = self.driver.find_element(By.TAG_NAME, "body")
        body.send_keys(Keys.TAB)
        skip = self.driver.switch_to.active_element
        self.assertEqual(skip.get_attribute("class"), "skip")
        self.assertGreaterEqual(self.run_script("return arguments[0].getBoundingClientRect().left", skip), 0)
        skip.send_keys(Keys.ENTER)
        self.assertEqual(self.run_script("return location.hash"), "#main")
        for link in self.driver.find_elements(By.CSS_SELECTOR, "nav a")[::3]:
            target = link.get_attribute("href").split("#")[1]
            link.send_keys(Keys.ENTER)
            self.until("const r = document.getElementById(arguments[0]).getBoundingClientRect();"
                       "return r.top > -60 && r.top < innerHeight - 60", target)
        self.until("return document.querySelector('nav a[aria-current]')")

    def test_ellipses_change_with_point_propagation_size_and_axes(self):
        place = self.opened("ellipse", "result-msa-sweep")
        seen = {self.picture(place)}
        curves = len(place.find_elements(By.CSS_SELECTOR, "path.ellipse"))
        self.assertEqual(curves, 4)  # Monte Carlo and three propagations
        for select in place.find_elements(By.CSS_SELECTOR, "select"):
            options = Select(select)
            current = options.all_selected_options[0].get_attribute("value")
            options.select_by_value(next(o.get_attribute("value") for o in options.options if o.get_attribute("value") != current))
            seen.add(self.picture(place))
        self.assertEqual(len(seen), 5)  # at first, case, noise law, size, axes
        self.keep("ellipses")
        for box in place.find_elements(By.CSS_SELECTOR, ".legend input")[1:]:
            box.click()
        self.assertEqual([p.get_attribute("data-formulation") for p in place.find_elements(By.CSS_SELECTOR, "path.ellipse")],
                         ["monte_carlo"])
        self.assertGreater(len(place.find_elements(By.CSS_SELECTOR, ".readout tbody tr")), 0)

    def test_ellipse_is_drawn_where_the_data_say(self):
        place = self.opened("ellipse", "result-msa-sweep")
        # 1 sigma, equal scales: the longest diameter of the drawn path against the axis of the data, by the axis' own ticks
        long, per_metre = self.run_script("""
            const data = JSON.parse(document.getElementById(arguments[0].dataset.source).textContent), k = data.keys.length;
            const selects = arguments[0].querySelectorAll("select");
            for (const s of [selects[selects.length - 2], selects[selects.length - 1]]) { s.value = 0; s.dispatchEvent(new Event("change")); }
            const row = data.rows.find((r) => r.slice(0, k).every((i) => i === 0) && data.formulations[r[k]] === "systematic");
            const points = arguments[0].querySelector("path[data-formulation=systematic]").getAttribute("d").slice(1).split("L").map((p) => p.split(" ").map(Number));
            let longest = 0;
            for (const a of points) for (const b of points) longest = Math.max(longest, Math.hypot(a[0] - b[0], a[1] - b[1]));
            const ticks = [...arguments[0].querySelectorAll(".axes text[text-anchor=middle]:not(.label)")].map((t) => [Number(t.getAttribute("x")), Number(t.textContent.replace("−", "-"))]);
            const scale = (ticks[ticks.length - 1][0] - ticks[0][0]) / (ticks[ticks.length - 1][1] - ticks[0][1]);
            return [longest / (2 * row[k + 3]), scale];""", place)
        self.assertAlmostEqual(long / per_metre, 1, delta=1e-3)  # 181 points and two decimals of a pixel

    def test_ellipses_lie_as_in_the_figure_beside_them(self):
        place = self.opened("ellipse", "result-msa-sweep")
        labels = self.run_script("""
            const selects = arguments[0].querySelectorAll("select"), axes = selects[selects.length - 1];
            return [0, 1].map((v) => { axes.value = v; axes.dispatchEvent(new Event("change"));
              return [...arguments[0].querySelectorAll("text.label")].map((t) => t.textContent); })""", place)
        self.assertEqual([label.split(" (")[0] for label in labels[0]], ["East", "North"])
        along, across = (float(re.search(r"azimuth ([\d.]+)°", label)[1]) for label in labels[1])
        self.assertTrue(labels[1][0].startswith("Along") and labels[1][1].startswith("Across"))
        self.assertAlmostEqual((along - across) % 360, 90, delta=0.2)  # to the left of it is up: turned, not mirrored
        joint = self.run_script("""const data = JSON.parse(document.getElementById(arguments[0].dataset.source).textContent), k = data.keys.length;
            return data.rows.find((r) => r.slice(0, k).every((i) => i === 0) && data.formulations[r[k]] === "joint")[k + 5];""", place)
        self.assertAlmostEqual(along, joint, delta=0.1)

    def test_maps_change_with_quantity_point_and_axes(self):
        for article in ("result-reliability-map", "result-msa-benefit"):
            place = self.opened("map", article)
            seen, count = {self.picture(place)}, 1
            for i in range(len(place.find_elements(By.CSS_SELECTOR, "select"))):
                options = Select(place.find_elements(By.CSS_SELECTOR, "select")[i])
                if i in (1, 2):
                    continue  # axes: below
                options.select_by_index(len(options.options) - 1 if i else 0)
                seen.add(self.picture(place))
                count += 1
            self.assertGreaterEqual(len(seen), count - 1)  # one choice may be what was there
        place = self.opened("map", "result-reliability-map")
        across, up = (Select(place.find_elements(By.CSS_SELECTOR, "select")[i]) for i in (1, 2))
        labels = self.run_script("return [...arguments[0].querySelectorAll('text.label')].map((t) => t.textContent)", place)
        across.select_by_visible_text("inclination")
        changed = self.run_script("return [...arguments[0].querySelectorAll('text.label')].map((t) => t.textContent)", place)
        self.assertNotEqual(labels, changed)
        self.assertIn("inclination (°)", changed)
        self.assertTrue(up.options)

    def test_map_says_the_value_that_the_data_have(self):
        place = self.opened("map", "result-msa-benefit")
        drawing = place.find_element(By.CSS_SELECTOR, "svg.map")
        self.run_script("arguments[0].focus()", drawing)
        drawing.send_keys(Keys.ARROW_RIGHT, Keys.ARROW_UP)
        first = place.find_element(By.CSS_SELECTOR, ".readout").text
        self.assertRegex(first, r"^azimuth [\d.]+°, inclination [\d.]+°: [\d.∞]+")
        drawing.send_keys(Keys.ARROW_LEFT)
        self.assertNotEqual(place.find_element(By.CSS_SELECTOR, ".readout").text, first)

    def test_dark_by_preference_and_by_the_button(self):
        def paper():
            return self.run_script("return getComputedStyle(document.body).backgroundColor")

        light = paper()
        self.keep("light")
        self.driver.find_element(By.ID, "theme").click()
        dark = paper()
        self.assertNotEqual(light, dark)
        self.run_script("localStorage.clear()")
        self.show(*DESKTOP, dark=True)
        self.assertEqual(paper(), dark)
        self.keep("dark")
        # text on paper: WCAG AA asks for 4.5 to 1
        for element in ("body", ".small", ".verdict.agrees", ".verdict.differs", ".verdict.finding", ".verdict.undecided", "nav a"):
            for scheme in ("light", "dark"):
                self.run_script("document.documentElement.dataset.theme = arguments[0]", scheme)
                ratio = self.run_script("""
                    const light = (c) => { const v = c.match(/[\\d.]+/g).slice(0, 3).map((x) => { x /= 255; return x <= .03928 ? x / 12.92 : ((x + .055) / 1.055) ** 2.4; }); return .2126 * v[0] + .7152 * v[1] + .0722 * v[2]; };
                    const a = light(getComputedStyle(document.querySelector(arguments[0])).color), b = light(getComputedStyle(document.body).backgroundColor);
                    return (Math.max(a, b) + .05) / (Math.min(a, b) + .05);""", element)
                self.assertGreaterEqual(ratio, 4.5, f"{element} {scheme}")

    def test_phone_has_no_sideways_scrolling(self):
        self.show(*PHONE)
        self.keep("phone")
        self.run_script("for (const d of document.querySelectorAll('details')) d.open = true")
        for place in self.driver.find_elements(By.CSS_SELECTOR, "[data-source]"):
            self.run_script("arguments[0].scrollIntoView()", place)
            self.until("return arguments[0].querySelector('svg:not(.sample)')", place)
        width = self.run_script("return [document.documentElement.scrollWidth, innerWidth]")
        self.assertEqual(width[0], PHONE[0])
        self.assertEqual(width[1], PHONE[0])
        outside = self.run_script("""return [...document.querySelectorAll('main *')].filter((e) => !e.closest('.scroll, svg, pre, button.figure, .skip, legend')
            && e.getBoundingClientRect().width > 0 && e.getBoundingClientRect().right > innerWidth + 1).map((e) => e.outerHTML.slice(0, 80))""")
        self.assertEqual(outside, [])

    def test_prints(self):
        self.show(720, 1000, dark=True)
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print", "features": [
            {"name": "prefers-color-scheme", "value": "dark"}]})
        self.assertEqual(self.run_script("return getComputedStyle(document.body).backgroundColor"), "rgb(255, 255, 255)")
        self.run_script("dispatchEvent(new Event('beforeprint'))")
        self.assertEqual(self.run_script("return document.documentElement.scrollWidth"), 720)
        cut = self.run_script("""return [...document.querySelectorAll('main *')].filter((e) => e.checkVisibility() && e.getBoundingClientRect().width > 0 &&
            (e.getBoundingClientRect().right > innerWidth + 1 || (getComputedStyle(e).overflowX !== 'visible' && e.scrollWidth > e.clientWidth + 1)))
            .map((e) => e.outerHTML.slice(0, 100))""")
        self.assertEqual(cut, [])
        self.keep("print")
        pdf = base64.b64decode(self.driver.execute_cdp_cmd("Page.printToPDF", {"printBackground": False})["data"])
        self.assertEqual(pdf[:5], b"%PDF-")
        pages = pdf.count(b"/Type /Page\n") + pdf.count(b"/Type /Page ")
        self.assertTrue(3 < pages <= 15, pages)  # seven results; all studies: docs/report.md
        if SCREENSHOTS:
            os.makedirs(SCREENSHOTS, exist_ok=True)
            with open(os.path.join(SCREENSHOTS, "report.pdf"), "wb") as file:
                file.write(pdf)


if __name__ == "__main__":
    if len(sys.argv) > 2 and not sys.argv[-1].startswith("-") and not sys.argv[-1].endswith(".html") and "." not in sys.argv[-1]:
        SCREENSHOTS = os.path.abspath(sys.argv.pop())
    REPORT = os.path.abspath(sys.argv.pop())
    if MISSING:
        print(f"skipped: not installed: {', '.join(MISSING)}")
        sys.exit(77)  # ctest shows it as skipped
    unittest.main()
