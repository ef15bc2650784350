"""The physics, once: equations of motion, contact, friction, transfer function, regrouping.

Plant, renderer, estimator, `simulate` and every fit call the functions of this folder;
no other place holds an equation of motion.
"""
