"use strict";
(function () {
  const plots = JSON.parse(document.getElementById("plots").textContent);
  const config = {
    responsive: true,
    displaylogo: false,
    modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"],
  };

  function colour(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  }

  // Text and grid in the page's colours, light or dark.
  function themed(layout) {
    const ink = colour("--ink"), grid = colour("--grid"), card = colour("--card");
    const update = {
      "paper_bgcolor": "rgba(0,0,0,0)",
      "plot_bgcolor": "rgba(0,0,0,0)",
      "font.color": ink,
      "font.family": getComputedStyle(document.body).fontFamily,
      "modebar.bgcolor": "rgba(0,0,0,0)",
      "modebar.color": colour("--soft"),
      "modebar.activecolor": colour("--accent"),
      "hoverlabel.bgcolor": card,
      "hoverlabel.font.color": ink,
      "hoverlabel.bordercolor": grid,
    };
    for (const key of Object.keys(layout)) {
      if (/^[xy]axis\d*$/.test(key)) {
        update[key + ".gridcolor"] = grid;
        update[key + ".linecolor"] = grid;
      }
    }
    return update;
  }

  function nested(update, layout) {
    const result = structuredClone(layout);
    for (const [path, value] of Object.entries(update)) {
      const keys = path.split(".");
      let place = result;
      for (const key of keys.slice(0, -1)) place = place[key] = place[key] || {};
      place[keys[keys.length - 1]] = value;
    }
    return result;
  }

  const linked = [];
  let busy = false;

  // Zooming one signal in time zooms them all.
  function follow(source, change) {
    if (busy) return;
    let range;
    for (const key of Object.keys(change)) {
      if (/^xaxis\d*\.autorange$/.test(key)) range = null;
      if (/^xaxis\d*\.range/.test(key)) range = source.layout.xaxis.range.slice();
    }
    if (range === undefined) return;
    busy = true;
    const update = range ? { "xaxis.range": range } : { "xaxis.autorange": true };
    Promise.all(linked.filter((div) => div !== source).map((div) => Plotly.relayout(div, update)))
      .finally(() => { busy = false; });
  }

  const drawn = Object.entries(plots).map(([id, plot]) => {
    const div = document.getElementById(id);
    if (plot.square) {
      plot.layout.height = Math.min(plot.layout.height, div.clientWidth + 110);
      div.style.height = plot.layout.height + "px";
    }
    return Plotly.newPlot(div, plot.data, nested(themed(plot.layout), plot.layout), config)
      .then(() => {
        if (!plot.linked) return;
        linked.push(div);
        div.on("plotly_relayout", (change) => follow(div, change));
      });
  });
  Promise.all(drawn).then(() => { document.body.dataset.drawn = String(drawn.length); });

  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const [id, plot] of Object.entries(plots)) {
      Plotly.relayout(document.getElementById(id), themed(plot.layout));
    }
  });
})();
