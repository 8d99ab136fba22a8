// Moves the slider of a page that `saltus` wrote and says what is wrong with it, for `check`.
(() => {
  const wrong = window.wrong;
  const expect = (holds, words) => { if (!holds) wrong.push(words); };
  const pixels = node => { const box = node.getBoundingClientRect(); return box.width * box.height; };
  const saltus = window.saltus;
  expect(saltus, "there is no window.saltus");
  if (saltus?.run) lookAtRun();
  else if (saltus) for (const option of document.querySelectorAll("#jump option")) look(Number(option.value));

  function look(jump) {
    saltus.select(jump);
    const slider = document.getElementById("time");
    const at = share => {
      slider.value = share * Number(slider.max);
      slider.dispatchEvent(new Event("input"));
      layout(`jump ${jump} at ${share} of its time`);
      return { ...saltus.state(), picture: document.getElementById("stage").innerHTML };
    };
    const [start, middle, end] = [at(0), at(0.5), at(1)];
    expect(start.time_s === 0 && end.time_s > middle.time_s, `jump ${jump}: the slider does not set the time`);
    expect(start.robot !== middle.robot && middle.robot !== end.robot, `jump ${jump}: the slider does not move the robot`);
    expect(start.picture !== end.picture, `jump ${jump}: the picture stays`);
    expect(end.trail > start.trail, `jump ${jump}: the trail does not grow`);
    expect(start.touching && !end.touching, `jump ${jump}: it does not leave the ground`);
    expect(end.axle_m[0] > start.axle_m[0], `jump ${jump}: it does not travel`);
    expect(document.querySelectorAll("#stage *").length > 40 && pixels(document.getElementById("stage")) > 5e4, `jump ${jump}: the stage is bare`);
    expect(!/NaN|undefined|Infinity/.test(document.querySelector(".page").innerHTML), `jump ${jump}: a number is not one`);
    keys(jump);
  }

  // A page of `saltus run --animate`.
  function lookAtRun() {
    const slider = document.getElementById("time");
    const at = share => {
      slider.value = share * Number(slider.max);
      slider.dispatchEvent(new Event("input"));
      layout(`the run at ${share} of its time`);
      return { ...saltus.state(), picture: document.getElementById("stage").innerHTML };
    };
    const [start, middle, end] = [at(0), at(0.5), at(1)];
    expect(start.time_s === 0 && end.time_s > middle.time_s && Math.abs(end.time_s - end.end_s) < 1e-9, "the slider does not set the time");
    expect(start.robot !== middle.robot, "the slider does not move the robot");
    expect(start.picture !== end.picture, "the picture stays");
    expect(end.trail > start.trail, "the trail does not grow");
    expect(!end.ran || Math.abs(end.x_m - start.x_m) > 0.1, "it does not travel");
    expect(document.querySelectorAll("#charts svg").length === 4 && document.querySelectorAll("#charts .fired").length > 0, "no leg is fired in the charts");
    expect(document.querySelectorAll("#charts .down").length > 0, "no foot comes down in the charts");
    expect(document.querySelectorAll("#legs tr").length > 2, "the table of legs is bare");
    expect(pixels(document.getElementById("stage")) > 4e4, "the stage is bare");
    expect(!/NaN|undefined|Infinity/.test(document.querySelector(".page").innerHTML), "a number is not one");
    const press = key => document.body.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
    saltus.draw(0);
    press("ArrowRight");
    expect(saltus.state().time_s > 0, "→ does not step");
    press("ArrowLeft");
    expect(saltus.state().time_s === 0, "← does not step back");
    press("ArrowUp");
    expect(saltus.state().time_s > 0, "↑ does not go to a firing");
    press(" ");
    expect(saltus.state().playing, "space does not play");
    press(" ");
    expect(!saltus.state().playing, "space does not pause");
    for (const radio of document.querySelectorAll("[name=speed]")) {
      radio.click();
      expect(saltus.state().speed === Number(radio.value), `speed ${radio.value} cannot be chosen`);
    }
  }

  // One frame on and back, the first event, and play by the keyboard.
  function keys(jump) {
    const press = key => document.body.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
    saltus.draw(0);
    press("ArrowRight");
    expect(saltus.state().time_s > 0, `jump ${jump}: → does not step`);
    press("ArrowLeft");
    expect(saltus.state().time_s === 0, `jump ${jump}: ← does not step back`);
    press("ArrowUp");
    // One at the very start is where it is already.
    const first = [...document.querySelectorAll("#ticks button")].map(b => Number(b.dataset.time)).find(t => t > 0);
    expect(saltus.state().time_s === first, `jump ${jump}: ↑ does not go to the first event`);
    press(" ");
    expect(saltus.state().playing, `jump ${jump}: space does not play`);
    press(" ");
    expect(!saltus.state().playing, `jump ${jump}: space does not pause`);
  }

  function layout(when) {
    const root = document.documentElement;
    expect(root.scrollWidth <= root.clientWidth, `${when}: ${root.scrollWidth} px in a window of ${root.clientWidth}`);
    const boxes = [...document.querySelectorAll("#ticks button, #stage text")].filter(node => node.textContent && node.getClientRects().length);
    const stage = document.getElementById("stage").getBoundingClientRect();
    for (const [k, node] of boxes.entries()) {
      const a = node.getBoundingClientRect();
      if (node.closest("#stage")) expect(a.left >= stage.left - 1 && a.right <= stage.right + 1 && a.top >= stage.top - 1 && a.bottom <= stage.bottom + 1, `${when}: ‘${node.textContent}’ is cut off`);
      for (const other of boxes.slice(0, k)) {
        // The force's number moves over the rest, with a halo.
        if (other.closest("[data-part=force]") || node.closest("[data-part=force]")) continue;
        const b = other.getBoundingClientRect();
        const over = Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 3;
        expect(!over, `${when}: ‘${node.textContent}’ lies over ‘${other.textContent}’`);
      }
    }
    const nameless = [...document.querySelectorAll("button, input, select")].filter(node => !(node.textContent || node.getAttribute("aria-label") || node.labels?.length));
    expect(nameless.length === 0, `${when}: ${nameless.length} controls have no name`);
  }

  const said = wrong.length ? [...new Set(wrong)].slice(0, 20).map(words => "wrong: " + words).join("\n") : `all well at ${innerWidth} px`;
  parent.postMessage(said, "*");
})();
