// Moves the slider of a page that `saltus` wrote and says what is wrong with it, for `check`.
(() => {
  const wrong = window.wrong;
  const expect = (holds, words) => { if (!holds) wrong.push(words); };
  const pixels = node => { const box = node.getBoundingClientRect(); return box.width * box.height; };
  const saltus = window.saltus;
  expect(saltus, "there is no window.saltus");
  if (saltus?.ball) lookAtBall();
  else if (saltus?.run) lookAtRun();
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

  // A page of `saltus run --animate` of a robot in space.
  function lookAtBall() {
    const slider = document.getElementById("time"), view = saltus.view;
    const at = share => {
      slider.value = share * Number(slider.max);
      slider.dispatchEvent(new Event("input"));
      layout(`the run at ${share} of its time`);
      return saltus.state();
    };
    const [start, middle, end] = [at(0), at(0.5), at(1)];
    expect(start.time_s === 0 && end.time_s > middle.time_s && Math.abs(end.time_s - end.end_s) < 1e-6, "the slider does not set the time");
    expect(start.robot !== middle.robot, "the slider does not move the robot");
    expect(Math.max(...[middle, end].map(at => Math.abs(at.x_m - start.x_m))) > 0.1, "it does not travel");
    expect((end.frames - 1) / end.end_s >= 30, `${end.frames} frames in ${end.end_s} s`);
    // What the page makes of the packed attitude is what the run said of its disc.
    let [down, open, force, missed, off] = [0, 0, 0, 0, 0];
    const tables = new Set();
    for (let share = 0; share <= 1; share += 0.004) {
      saltus.draw(share * end.end_s);
      const it = saltus.state(), turn = (it.lying.heading - it.told.heading) / (2 * Math.PI);
      off += !(Math.abs(it.lying.roll - it.told.roll) < 2e-3 && Math.abs(turn - Math.round(turn)) < 1e-3);
      if (it.guesses) expect(Math.abs(it.norm - 1) < 1e-6 && it.misses.vertical < 3 && it.misses.place < 3, `the estimate at ${it.time_s} s is off`);
      missed = Math.max(missed, it.misses.vertical);
      tables.add(document.getElementById("legs").innerHTML);
      [down, open, force] = [down + it.down, open + it.open, Math.max(force, it.force)];
    }
    // Between two frames the ball may choose another plane.
    expect(off <= 2, `roll or heading at ${off} of 251 times are not those of the run`);
    expect(!end.guesses || missed > 0, "the estimate is the truth");
    expect(tables.size > 5, "the table of legs stays");
    expect(down > 5 && open > 0 && force > 20 && force < 5000, `feet down ${down}, valves open ${open}, greatest force ${force} N`);
    expect(document.querySelectorAll("#charts svg").length >= 4 && document.querySelectorAll("#charts .fired").length > 0 && document.querySelectorAll("#charts .down").length > 0, "the charts are bare");
    expect(!/NaN|undefined|Infinity/.test(document.querySelector(".page").innerHTML), "a number is not one");
    if (!window.hasPicture) {
      expect(!view && !document.getElementById("none").hidden && document.getElementById("stage").hidden && pixels(document.getElementById("none")) > 1000, "without WebGL it does not say so");
    } else if (view) {
      lookAtPicture(view, end.end_s);
    } else wrong.push("there is no WebGL");
    keysOfBall();
  }

  // Cameras, shadow, estimate, disc and colours of a picture in space.
  function lookAtPicture(view, end) {
    const $ = id => document.getElementById(id);
    const shown = () => { saltus.draw(saltus.state().time_s); return view.pixels(); };
    const differ = (a, b) => { let count = 0; for (let k = 0; k < a.length; k += 4) if (Math.abs(a[k] - b[k]) + Math.abs(a[k + 1] - b[k + 1]) + Math.abs(a[k + 2] - b[k + 2]) > 24) count++; return count; };
    const count = (all, is) => { let sum = 0; for (let k = 0; k < all.length; k += 4) if (is(all[k], all[k + 1], all[k + 2])) sum++; return sum; };
    // The line that it follows is as red, and has no blue.
    const isRed = (r, g, b) => r > 1.7 * g && r > 1.7 * b && r > 90 && g < 2 * b;
    const press = key => document.body.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
    expect(pixels($("stage")) > 5e4 && view.finish() === 0, "the stage is bare");
    saltus.draw(0.4 * end);
    const before = shown();
    expect(before.length >= 4 * 300 * 200 && differ(before, shown()) === 0, "the same instant is another picture");
    const { target } = saltus.state().camera;
    saltus.draw(0.6 * end);
    const after = shown();
    expect(differ(before, after) > 500, "the picture stays");
    expect(Math.hypot(target[0] - saltus.state().camera.target[0], target[1] - saltus.state().camera.target[1]) > 0.05, "the camera does not follow");
    // The middle of the picture is the robot; its shadow is darker than the ground.
    for (const [id, least] of [["disc", 500], ["ghost", 30]]) {
      if (id === "ghost" && !saltus.state().guesses) continue;
      const key = { disc: "p", ghost: "e" }[id];
      press(key);
      expect(!$(id).checked && differ(after, shown()) > least, `without the ${id} the picture is the same`);
      press(key);
      expect($(id).checked && differ(after, shown()) === 0, `the ${id} does not come back`);
    }
    // An open valve is red, and nothing else is.
    const [shut, open] = [false, true].map(is => {
      for (let t = 0.2 * end; t < end; t += 1e-3) {
        saltus.draw(t);
        const it = saltus.state();
        if (it.open > 0 === is) return count(shown(), isRed);
      }
      return null;
    });
    expect(open > 40 && (shut === null || shut === 0), `red pixels with a valve open: ${open}, with none: ${shut}`);
    saltus.draw(0.6 * end);
    const drag = (type, x) => $("stage").dispatchEvent(new PointerEvent(type, { pointerId: 1, clientX: x, clientY: 200, buttons: 1, bubbles: true }));
    $("stage").setPointerCapture = () => {};
    for (const [type, x] of [["pointerdown", 200], ["pointermove", 260], ["pointerup", 260]]) drag(type, x);
    expect(differ(after, shown()) > 500, "a drag does not turn the picture");
    const { distance } = saltus.state().camera;
    $("stage").dispatchEvent(new WheelEvent("wheel", { deltaY: -300, cancelable: true }));
    expect(saltus.state().camera.distance < 0.9 * distance, "the wheel does not come nearer");
    for (const mode of ["behind", "orbit"]) {
      press("c");
      expect(saltus.state().mode === mode && document.querySelector("[name=camera]:checked").value === mode, `c does not choose the camera ${mode}`);
      saltus.draw(0.5 * end);
      expect(count(shown(), () => true) > 0 && view.finish() === 0, `the camera ${mode} draws nothing`);
    }
    // A camera that stays where it is sees another picture of another time, and its target stays.
    const stays = saltus.state().camera.target.join();
    saltus.draw(0.52 * end);
    expect(saltus.state().camera.target.join() === stays, "the camera that stays moves");
    press("c");
    Object.assign(view.camera, saltus.START);
  }

  function keysOfBall() {
    const press = key => document.body.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
    saltus.draw(0);
    press("ArrowRight");
    expect(saltus.state().time_s > 0, "→ does not step");
    press("ArrowLeft");
    expect(saltus.state().time_s === 0, "← does not step back");
    press("ArrowUp");
    expect(saltus.state().time_s > 0, "↑ does not go to a firing");
    press("End");
    expect(saltus.state().time_s === saltus.state().end_s, "End does not go to the end");
    saltus.draw(0);
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
