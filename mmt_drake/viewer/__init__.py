"""The live view of a run: a scene that Meshcat's script draws, charts beside it, and sliders.

`viewer` serves the page and what it shows, `scene` draws, `charts` says what is charted.
`mmt_drake.systems.live_view` feeds them from a diagram.
"""
