"""The thesis's open question: what makes its rendered force wrong while its estimated force follows?

`causes` are changes of a scenario that has none of them, `claims` what the thesis's figures show as something that runs
either show too or do not; `report.ablation` puts in one cause after the other and judges.
"""
