"""What the renderers of `mmt_drake.systems` compute: how parameters are taken up, and passivity control."""
