"""Proof apart from product: experiments, trials, benches and injected faults, every one of them a study."""
