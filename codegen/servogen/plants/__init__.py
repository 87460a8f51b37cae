"""Machine models: continuous state spaces, their exact discretisation, servo and CasADi models."""
