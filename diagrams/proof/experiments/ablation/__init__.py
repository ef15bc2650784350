"""The thesis's open question: what makes its rendered force wrong while its estimated force follows?

`causes` are changes of a scenario that has none of them, `claims` what the thesis's figures show as something that runs
either show too or do not, whichever force was measured, the raw one or the filtered one; `report.ablation` puts in one
cause after the other and judges, `findings` concludes.
"""
