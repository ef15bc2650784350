"""What the operator's hand does: scripted, recorded, or modelled after a human's."""
