"""Cached kernels are dropped when, and only when, a source has changed."""

from mmt_drake.kernel_cache import discard_stale


def test_a_changed_source_drops_every_cached_kernel_and_an_unchanged_one_none(tmp_path):
    (tmp_path / "law.py").write_text("a = 1")
    cache = tmp_path / "sub" / "__pycache__"
    cache.mkdir(parents=True)
    (tmp_path / "sub" / "caller.py").write_text("import law")
    kernel = cache / "caller.f-1.py311.1.nbc"
    kernel.write_text("old")
    assert discard_stale(tmp_path) and not kernel.exists()
    kernel.write_text("new")
    assert not discard_stale(tmp_path) and kernel.exists()
    (tmp_path / "law.py").write_text("a = 22")
    assert discard_stale(tmp_path) and not kernel.exists()


def test_a_folder_whose_kernels_no_other_calls_drops_nothing(tmp_path):
    (tmp_path / "law.py").write_text("a = 1")
    for folder in ("cli", "analysis", "effects", "systems"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "a.py").write_text("a = 1")
    discard_stale(tmp_path)
    for folder in ("cli", "analysis", "effects", "systems"):
        (tmp_path / folder / "a.py").write_text("a = 22")
    assert not discard_stale(tmp_path)


def test_a_new_source_counts_as_a_change(tmp_path):
    (tmp_path / "law.py").write_text("a = 1")
    discard_stale(tmp_path)
    (tmp_path / "effect.py").write_text("b = 1")
    assert discard_stale(tmp_path)
    assert not discard_stale(tmp_path)
