"""The concealed-effect trial: recordings made by a physics engine of their own, labels sealed, diagnoses scored."""
