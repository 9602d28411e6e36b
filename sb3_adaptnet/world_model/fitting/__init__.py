"""From a policy to a fitted world model: data, stages of the fit, a table of errors."""
