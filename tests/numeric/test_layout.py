from mmt_drake.numeric.layout import Layout


def test_parts_follow_one_another() -> None:
    layout = Layout()
    assert (layout(3), layout(), layout.part(2), layout.size) == (0, 3, slice(4, 6), 6)
