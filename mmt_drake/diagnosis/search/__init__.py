"""The search: which effects to try beside the model, from which starts, and the best sets of them."""
