// The switch between languages, and the enlarged view of a picture.
(() => {
  "use strict";
  const switches = [...document.querySelectorAll("[data-language]")];
  const speak = (language) => {
    document.documentElement.lang = language;
    for (const element of document.querySelectorAll("[data-zh]")) element.textContent = element.dataset[language];
    for (const button of switches) button.setAttribute("aria-pressed", button.dataset.language === language);
  };
  for (const button of switches) button.onclick = () => speak(button.dataset.language);
  const wanted = location.hash.match(/^#lang=(en|zh)$/);
  speak(wanted ? wanted[1] : document.documentElement.lang);

  const lightbox = document.getElementById("lightbox"), large = lightbox.querySelector("img");
  const where = lightbox.querySelector(".where");
  let ranges = null;
  for (const button of document.querySelectorAll("button.zoom")) {
    button.onclick = () => {
      const small = button.querySelector("img");
      large.src = small.src;
      large.alt = small.alt;
      ranges = button.dataset.ranges ? button.dataset.ranges.split(" ").map(Number) : null;
      where.hidden = !ranges;
      where.textContent = "";
      lightbox.classList.remove("actual");
      lightbox.showModal();
    };
  }
  // Where on the cable the pointer is: ranges are the azimuths and positions of the picture's edges.
  large.onpointermove = (event) => {
    if (!ranges) return;
    const [left, right, top, bottom] = ranges;
    const angle = left + ((right - left) * event.offsetX) / large.clientWidth;
    const position = top + ((bottom - top) * event.offsetY) / large.clientHeight;
    where.textContent = where.getAttribute(`data-form-${document.documentElement.lang}`)
      .replace("{angle}", angle.toFixed(1)).replace("{position}", position.toFixed(4));
  };
  // A click enlarges to the picture's own size, around the place that was clicked.
  const pane = lightbox.querySelector(".pane");
  const resize = (across, down) => {
    if (lightbox.classList.toggle("actual")) {
      pane.scrollLeft = across * large.clientWidth - pane.clientWidth / 2;
      pane.scrollTop = down * large.clientHeight - pane.clientHeight / 2;
    }
  };
  large.onclick = (event) => resize(event.offsetX / large.clientWidth, event.offsetY / large.clientHeight);
  lightbox.querySelector(".size").onclick = () => resize(0.5, 0.5);
  lightbox.querySelector(".close").onclick = () => lightbox.close();
})();
