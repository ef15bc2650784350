"""A second flexible object, which shares no physics with `mmt_drake.model`: what holds on both is no kinship."""
