"""Commands that take recordings and give models, comparisons and diagnoses."""
