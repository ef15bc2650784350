"""Concealed effects of arms that another engine simulates: `trial --arms`."""
