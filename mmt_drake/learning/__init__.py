"""What is diagnosed is felt: named physics enters the model that a renderer has, while it is felt.

A learner watches the contact beside an estimator. Where the estimator's numbers do not explain the force it holds a
window of the contact against the library of effects, by the rules of `mmt_drake.diagnosis`, and tells estimator and
renderer the laws that are named: at the depth of a law, and with values that are passive.
"""
