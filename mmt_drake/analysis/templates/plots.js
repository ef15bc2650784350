(async () => {
  const places = [...document.querySelectorAll(".plot")];
  try {
    const bytes = Uint8Array.from(atob(document.getElementById("packed").textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    const { library, figures } = JSON.parse(await new Response(stream).text());
    const script = document.createElement("script");
    script.textContent = library;
    document.head.append(script);
    const touched = matchMedia("(pointer: coarse)").matches; // there a finger scrolls the page
    const config = {
      responsive: true,
      displaylogo: false,
      toImageButtonOptions: { format: "svg" },
      modeBarButtons: [["toImage"], ["zoom2d", "pan2d"], ["zoomIn2d", "zoomOut2d", "resetScale2d"]],
    };
    for (const [i, place] of places.entries()) {
      const layout = touched ? { ...figures[i].layout, dragmode: false } : figures[i].layout;
      await Plotly.newPlot(place, figures[i].data, layout, config);
    }
    const resize = (width) => places.forEach((place) => Plotly.relayout(place, width(place)));
    addEventListener("beforeprint", () => // paper is narrower than a screen
      resize((place) => ({ width: place.closest(".half") ? 325 : 670, autosize: false })));
    addEventListener("afterprint", () => resize(() => ({ width: null, autosize: true })));
    document.documentElement.dataset.drawn = "yes";
  } catch (error) {
    for (const place of places) place.textContent = "This browser cannot draw the figures: " + error;
  }
})();
