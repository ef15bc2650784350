"""What a run looks like while it runs: a scene in Meshcat, charts beside it.

`scene` draws into Meshcat, `charts` sends samples through Meshcat's own connection to the page that draws them, and
`viewer` starts both. `mmt_drake.systems.live_view` feeds them from a diagram.
"""
