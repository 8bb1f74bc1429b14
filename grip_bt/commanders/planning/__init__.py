"""Planning: free paths by OMPL, straight paths, grasp choice, and the requests that ask for them."""
