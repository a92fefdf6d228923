"""What knows no actuator: errors, files, threads, linear least squares."""
