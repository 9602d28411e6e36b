"""Building blocks of the networks: recurrence, convolution, normalisation, precision, penalties."""
