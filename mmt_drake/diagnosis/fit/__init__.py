"""A model on recordings: what is free, what must be reproduced, the fit and how sure it is."""
