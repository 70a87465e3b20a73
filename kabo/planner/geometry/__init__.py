"""What the search knows of motions: refusals of geometric procedures, evaluation of skeletons, workers that ask ahead."""
